"""Loops that write the rows of contacts and of forces."""
