"""Contacts and the forces in them: what a robot stands on, what its joints then need, and tasks of forces and momentum."""
