"""Loops of inverse kinematics."""
