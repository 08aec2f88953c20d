"""Checks configurations against the joint limits, and interpolates between two of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput

from ..base.checks import Array, finite, finite_scalar, not_negative, numbers, scalar
from .abilities import Robot
from .answers import difference, integrate, joint_names, joint_positions, joint_units, limit_of


class Configurations:
    """A base of robots; see :class:`tasks.PinocchioRobot` and :class:`tasks.PlanarArm`."""

    def check_limits(self: Robot, q: ArrayLike, *, tolerance: float = 1e-6) -> None:
        """Raise if a configuration is outside the position limits.

        Parameters
        ----------
        q : array, shape (nq,)
        tolerance : float
            How far beyond its range a joint may be [rad], [m].

        Raises
        ------
        InvalidInput
            If a joint is outside; the message lists each one with its position and range. Also if a number is NaN, or
            q has a wrong size.
        """
        slack = scalar(not_negative(tolerance, "tolerance"), "tolerance")
        state, limits = self.at(_numbers(self, q, "q"), np.zeros(self.nv)), limit_of(self, "position")
        if not np.isfinite(state.q).all():
            raise InvalidInput(f"q = {state.q.tolist()} must be finite")
        if limits is None:
            return
        positions, (low, high) = joint_positions(state), limits
        outside = np.flatnonzero((positions < low - slack) | (positions > high + slack))
        if len(outside):
            names, units = joint_names(self), joint_units(self)
            told = "; ".join(
                f"{names[i]!r} is at {positions[i]:.6g} {units[i]}, and its range is {low[i]:.6g} .. {high[i]:.6g}"
                for i in outside
            )
            raise InvalidInput(f"q is outside the position limits of {self!r}: {told}")

    def interpolate(self: Robot, start: ArrayLike, end: ArrayLike, share: float) -> Array:
        """The configuration after a share of the shortest way from one to another, joint by joint.

        Parameters
        ----------
        start, end : array, shape (nq,)
        share : float
            0 is the start, 1 the end; other values extrapolate.

        Returns
        -------
        array, shape (nq,)

        Raises
        ------
        InvalidInput
            If a configuration has a wrong size for this robot, or a number is not finite.
        """
        first, last = _numbers(self, finite(start, "start"), "start"), _numbers(self, finite(end, "end"), "end")
        return integrate(self, first, finite_scalar(share, "share") * difference(self, first, last))


def _numbers(robot: Robot, q: ArrayLike, what: str) -> Array:
    position = numbers(q, what)
    if position.shape != (robot.nq,):
        raise InvalidInput(f"{what} has shape {position.shape}; {robot!r} takes ({robot.nq},)")
    return position
