"""Path polish: waypoints moved for what is sensed along the path, the order of visits fixed."""
