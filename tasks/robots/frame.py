r"""Frames of a robot: pose, Jacobian and drift.

In the coordinates of the world, with p the origin of the frame and the columns of R its axes,

.. math:: \dot p = J_p v, \quad \omega = J_\omega v, \qquad \ddot p = J_p a + \dot J_p v, \quad
   \dot\omega = J_\omega a + \dot J_\omega v.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..base.checks import Array
from .kernels.block import NOTHING

#: The frame of the world.
WORLD = "universe"


class Frame(Protocol):
    """One frame at one instant.

    Attributes
    ----------
    position : array, shape (3,)
        p [m].
    rotation : array, shape (3, 3)
        R; of a planar arm, of shape (1,), its angle about z [rad], unwrapped.
    linear, angular : array, shape (3, nv)
        J_p and J_omega.
    linear_drift, angular_drift : array, shape (3,)
        The accelerations [m/s^2], [rad/s^2] at zero joint acceleration.
    """

    @property
    def position(self) -> Array: ...
    @property
    def rotation(self) -> Array: ...
    @property
    def linear(self) -> Array: ...
    @property
    def angular(self) -> Array: ...
    @property
    def linear_drift(self) -> Array: ...
    @property
    def angular_drift(self) -> Array: ...


def without_round_off(jacobian: Array) -> Array:
    """The array with round-off replaced by 0."""
    jacobian[np.abs(jacobian) < NOTHING] = 0.0
    return jacobian


@dataclass(frozen=True, eq=False, slots=True)
class FixedFrame:
    """A frame with all its numbers computed."""

    position: Array
    rotation: Array
    linear: Array
    angular: Array
    linear_drift: Array
    angular_drift: Array


def planar_frame(pose: Array, jacobian: Array, drift: Array) -> FixedFrame:
    """A frame that moves in the plane z = 0 and turns about z.

    Parameters
    ----------
    pose : array, shape (3,)
        x [m], y [m] and the angle [rad].
    jacobian : array, shape (3, nv)
        Of these three.
    drift : array, shape (3,)
        Their acceleration while the joints do not accelerate.
    """
    parts = np.zeros((6, jacobian.shape[1] + 2))
    for row, own in (0, 0), (1, 1), (5, 2):
        parts[row, :-2], parts[row, -2], parts[row, -1] = jacobian[own], pose[own], drift[own]
    J, place, change = without_round_off(parts[:, :-2]), parts[:, -2], parts[:, -1]
    return FixedFrame(place[:3], pose[2:], J[:3], J[3:], change[:3], change[3:])
