"""From the state of a robot to its motion, one call a tick, and from one stack to another without a jump."""
