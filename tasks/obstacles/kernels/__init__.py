"""Loops of distances: where pairs are nearest, what a tick can take of that, and the rows that keep it."""
