"""The lowest layer, without robotics: checks, rotations, live attributes, loops."""
