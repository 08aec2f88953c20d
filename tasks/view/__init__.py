"""A controller in the browser: its robot, its targets and its priorities, touched while it moves."""
