"""Loops that measure tasks of frames."""
