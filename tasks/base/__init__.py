"""What stands on nothing of robotics: checks, rotations, live attributes, loops."""
