"""Loops of distances: nearest points, reserve within a tick, and rows."""
