"""Loops that measure tasks of frames: errors, Jacobians, drifts, and curvatures."""
