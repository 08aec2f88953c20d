"""Loops of distances: closest points, reserve within a tick, and rows."""
