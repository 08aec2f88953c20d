"""Readers of model files, URDF and MJCF."""
