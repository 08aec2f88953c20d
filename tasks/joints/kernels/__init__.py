"""Loops that measure tasks of joints."""
