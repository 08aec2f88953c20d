"""Loops of secondary criteria."""
