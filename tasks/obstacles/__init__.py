"""Collision avoidance: distances of links to obstacles, and of the bodies of a robot to each other."""
