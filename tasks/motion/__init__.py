"""From a stack to motion: where to be when, the controller, and the closed loop."""
