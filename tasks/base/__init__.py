"""The lowest floor, without robotics: checks, rotations, live attributes, loops."""
