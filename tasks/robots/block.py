"""A frame as one array, for compiled loops: where each of its numbers is.

All in the axes of the world, or of the frame that stands for it; matrices by rows. ``n`` is the number of joint
velocities.
"""

from __future__ import annotations

#: p [m] (3,); R (9,); the unwrapped angle about z [rad] and whether the robot is planar, 1.0 or 0.0.
POSITION, ROTATION, ANGLE, PLANAR = 0, 3, 12, 13
#: Accelerations while the joints do not accelerate, and velocities, (3,) each.
LINEAR_DRIFT, ANGULAR_DRIFT, LINEAR_VELOCITY, ANGULAR_VELOCITY = 14, 17, 20, 23
#: J_p and J_omega, (6, n).
JACOBIAN = 26


def size(n: int) -> int:
    """How many numbers a frame has."""
    return JACOBIAN + 6 * n
