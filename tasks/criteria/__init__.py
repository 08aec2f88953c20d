"""Secondary criteria, optimised in the null space of the tasks above."""
