"""Joint limits, one kind a file: position, velocity, acceleration, torque."""
