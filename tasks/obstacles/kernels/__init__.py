"""Loops of distances: closest points, the reserve for the motion within a tick, and rows."""
