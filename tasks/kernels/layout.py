"""What the kernel that writes rows is told: a list of numbers a part, most of them addresses.

Every list begins with KIND, the addresses of the rows it owns (A, LOWER, UPPER) and their number. What follows depends
on the kind. Arrays are of float64 or int64, contiguous.
"""

from __future__ import annotations

#: Of the whole: unknowns, configuration, velocities, joint Jacobians (6 x columns, by columns), number of parts, their
#: lists.
N, Q, V, JOINTS, PARTS, LISTS = range(6)

#: Of every part.
KIND, A, LOWER, UPPER, ROWS, GAIN = range(6)
#: A frame to be brought to a place, a point likewise, joints to positions, and the limits of the joints.
PLACE, POINT, POSTURE, LIMITS = range(4)

#: Of PLACE and POINT: MASK (rows,) picks coordinates of those that there are; TARGET holds p, its velocity, R by rows,
#: omega.
MASK, TARGET, TRANSLATION = 6, 7, 8
#: Of PLACE: the axes (WORLD, LOCAL, SPATIAL), whether position and rotation count; where the joint is that carries the
#: frame (ROTATION by columns, TRANSLATION), where the frame is on it (MOUNTED: R by rows, p); what moves it: SUPPORTS
#: columns of the joint Jacobians, and the velocity of each.
AXES, LINEAR, ANGULAR, ROTATION, MOUNTED, SUPPORT, SUPPORTS = range(9, 16)
WORLD, LOCAL, SPATIAL = range(3)
#: Of POINT: its Jacobian (3 x n, by columns).
POINT_JACOBIAN = 9
#: Of POSTURE: where in q the positions are, and where they should be, with what velocity.
PLACES, WANTED = 6, 7
#: Of LIMITS: where in q each position is, or -1; and the numbers of :data:`FIELDS` for each joint.
NUMBERS = 7
#: Lowest and highest position; the velocity limit as one of the rows and as it is for the way back; the acceleration
#: limit as one of the rows and as it is for braking; how fast to come back; dt. Infinite where there is none.
FIELDS = ("low", "high", "speed", "back_speed", "acceleration", "braking", "return_speed", "dt")

#: Length of a list.
LENGTH = 16
