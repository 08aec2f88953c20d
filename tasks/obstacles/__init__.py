"""Distances: of links to obstacles, and of a robot to itself."""
