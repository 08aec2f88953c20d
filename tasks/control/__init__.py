"""The controller, one call a tick, and transitions from one stack to another."""
