"""Loops that write the frames of robots."""
