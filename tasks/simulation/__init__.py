"""Closed-loop simulation of a controller with a plant, and records of the motion."""
