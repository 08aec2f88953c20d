"""Loops of linear algebra and of rotations."""
