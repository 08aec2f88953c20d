"""Loops of the control law of all tasks, of joint limits, of damping, and of the motion equation."""
