r"""A frame of a robot: where it is, and how it follows the joints.

In the coordinates of the world, with p the origin of the frame and the columns of R its axes,

.. math:: \dot p = J_p v, \quad \omega = J_\omega v, \qquad \ddot p = J_p a + \dot J_p v, \quad
   \dot\omega = J_\omega a + \dot J_\omega v.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .._checks import Array
from ..rotations import cross


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
        The accelerations [m/s^2], [rad/s^2] while the joints do not accelerate.
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


#: A joint that moves a frame by less than this [m/rad], [1] does not move it: it is round-off, and a row of it would be
#: a task that none can meet, for which the joints would run to their limits.
NOTHING = 1e-13


def without_round_off(jacobian: Array) -> Array:
    """The same array, with 0 in the place of round-off."""
    jacobian[np.abs(jacobian) < NOTHING] = 0.0
    return jacobian


@dataclass(frozen=True, eq=False, slots=True)
class FixedFrame:
    """A frame whose numbers are all there."""

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


def relative(root: Frame, frame: Frame, v: Array) -> FixedFrame:
    r"""`frame` as an observer sees it who rides on `root`: in its coordinates, and with its motion taken off.

    With :math:`r = R_0^T (p - p_0)`, :math:`\omega_0` in the coordinates of the root, and joint velocities v,

    .. math::

        \dot r = R_0^T (\dot p - \dot p_0) - \omega_0 \times r, \qquad
        \ddot r = R_0^T (\ddot p - \ddot p_0) - \dot\omega_0 \times r - 2 \omega_0 \times \dot r
            - \omega_0 \times (\omega_0 \times r).
    """
    turned = root.rotation.T
    r = turned @ (frame.position - root.position)
    spin = turned @ root.angular
    linear = turned @ (frame.linear - root.linear) + cross(r, spin)
    angular = turned @ (frame.angular - root.angular)
    omega, rate = spin @ v, linear @ v
    linear_drift = (
        turned @ (frame.linear_drift - root.linear_drift)
        - np.cross(turned @ root.angular_drift, r)
        - 2.0 * np.cross(omega, rate)
        - np.cross(omega, np.cross(omega, r))
    )
    angular_drift = turned @ (frame.angular_drift - root.angular_drift) - np.cross(omega, angular @ v)
    return FixedFrame(r, turned @ frame.rotation, linear, angular, linear_drift, angular_drift)
