"""A running controller in the browser: its robot, targets and priorities are shown, and changed while it moves."""
