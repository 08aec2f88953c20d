"""Robots: protocols, planar arms, Pinocchio robots, and readers of model files."""
