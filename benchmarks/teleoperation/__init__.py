"""Teleoperation: each library in its own closed loop, all following the same targets."""
