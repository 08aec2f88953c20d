"""The layout of a frame block: pose, velocities, drifts and Jacobian of one frame in one array.

Lengths in [m], angles in [rad], all in the axes of the world, or of the frame that stands for it.
"""

from __future__ import annotations

#: Where the origin is (3,), how the axes stand (9, by rows), and of a robot in the plane the unwrapped angle about z.
POSITION, ROTATION, ANGLE = 0, 3, 12
#: 1 where the frame moves in the plane z = 0 and turns about z, else 0.
PLANAR = 13
#: The accelerations while the joints do not accelerate, and the velocities (3,): kept up where somebody needs them.
LINEAR_DRIFT, ANGULAR_DRIFT, LINEAR_VELOCITY, ANGULAR_VELOCITY = 14, 17, 20, 23
#: J_p and J_omega, (6, n) by rows.
JACOBIAN = 26
#: A joint that moves a frame by less than this [m/rad], [1] does not move it: it is round-off, and a row of it would be
#: a task that none can meet, for which the joints would run to their limits.
NOTHING = 1e-13


def size(n: int) -> int:
    """Numbers of a block, for n joint velocities."""
    return JACOBIAN + 6 * n
