"""Targets as functions of time: trajectories, timing laws, paths, polynomials, rotations."""
