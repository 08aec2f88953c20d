"""A hand leads a robot: each library in closed loop with its own motion, all with the same targets."""
