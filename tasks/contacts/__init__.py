"""Contacts: what a robot stands on, the forces in it, and tasks of forces, momentum and balance."""
