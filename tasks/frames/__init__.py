"""Tasks and limits of a frame of the robot: position, orientation, pose, axis, plane, centre of mass."""
