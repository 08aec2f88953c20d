"""Robots from files: what a file says, in which language, and the model that it makes."""
