"""The layout of a frame block: pose, velocities, drifts and Jacobian of one frame in one array.

Lengths are in m, angles in rad, vectors along the axes of the world, or of the frame that stands for it.
"""

from __future__ import annotations

#: Position p of the origin (3,); rotation matrix R (9, by rows); for planar robots, the unwrapped angle about z.
POSITION, ROTATION, ANGLE = 0, 3, 12
#: 1 where the frame moves in the plane z = 0 and turns about z, else 0.
PLANAR = 13
#: Drifts, which are the accelerations while the joints do not accelerate, and velocities, (3,) each: written on demand.
LINEAR_DRIFT, ANGULAR_DRIFT, LINEAR_VELOCITY, ANGULAR_VELOCITY = 14, 17, 20, 23
#: J_p and J_omega, (6, n) by rows.
JACOBIAN = 26
#: An entry of a Jacobian below this [m/rad], [1] is round-off and set to 0. A row of round-off would be a task that
#: cannot be met, for which the joints would run to their limits.
NOTHING = 1e-13


def size(n: int) -> int:
    """The size of a block for n joint velocities."""
    return JACOBIAN + 6 * n
