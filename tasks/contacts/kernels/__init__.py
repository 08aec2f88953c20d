"""Loops that write the rows of contacts, of their forces, of momentum and of balance."""
