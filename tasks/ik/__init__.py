"""Inverse kinematics: a stack solved to convergence."""
