"""Surveys within endurance: where UAVs fly and measure so that the map of a field is best (the whole of the paper)."""
