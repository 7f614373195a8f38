"""The environment a mission is flown in: region, terrain, wind, radio."""
