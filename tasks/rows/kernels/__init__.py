"""Loops of the law of all tasks, and of joint limits."""
