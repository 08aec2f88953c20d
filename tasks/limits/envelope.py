r"""What the joint limits of one stack know of each other, so that none asks for what another forbids.

Each limit alone bounds x to an interval that is never empty. Two of them may contradict each other: a joint that
comes too fast cannot keep both its range and its acceleration limit. The limits are therefore taken in an order of
hardness, whatever their levels: acceleration, position, velocity; those of one kind as they stand in
the stack. A softer limit is relaxed just so far that it meets what the harder ones leave,

.. math::

    [l, u] \;\leftarrow\; [\min(l, U),\ \max(u, L)], \qquad
    [L, U] \;\leftarrow\; [L, U] \cap [l, u],

beginning with :math:`[L, U] = \pm a_{max}` at acceleration order and :math:`v \pm a_{max} dt` at velocity order.
Every intersection is nonempty, so all limits together can be kept at every tick, from any state. From a state
within the velocity limit in which the joint can still stop inside its range, nothing is relaxed.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hqp import InvalidInput

from .._checks import Array
from ..part import Order, Part, Tick
from ..robots.robot import Robot, limit_of
from .acceleration import JointAccelerationLimit
from .limit import JointLimit, SymmetricLimit
from .position import JointPositionLimit
from .velocity import JointVelocityLimit

#: What may be relaxed, the harder first. Acceleration limits never are.
RELAXED = (JointPositionLimit, JointVelocityLimit)


class Envelope:
    """The joint limits of one stack at work on one robot.

    Where a stack has a position limit, but none of another kind, the robot's own counts for braking and for
    the way back.

    Parameters
    ----------
    rows : iterable of (Part, lower, upper)
        All parts of the stack, the highest level first, and the bounds that each writes.
    robot : Robot
    order : {"velocity", "acceleration"}

    Attributes
    ----------
    limits : tuple of JointLimit
        All that the stack has.
    acceleration, velocity : array, shape (nv,)
        The tightest limits [rad/s^2, rad/s]; infinite where there is none.
    ranges : dict of JointPositionLimit to array, shape (2, nv)
        Lowest and highest positions [rad] of each position limit.

    Raises
    ------
    InvalidInput
        If a position limit at acceleration order has nothing to brake with.
    """

    acceleration: Array
    velocity: Array
    ranges: dict[JointPositionLimit, Array]

    def __init__(self, rows: Iterable[tuple[Part, Array, Array]], robot: Robot, order: Order) -> None:
        rows = list(rows)
        parts = [part for part, _, _ in rows]
        self.limits = tuple(part for part in parts if isinstance(part, JointLimit))
        self.ranges = {part: part.range(robot) for part in parts if isinstance(part, JointPositionLimit)}
        self.acceleration = _tightest(JointAccelerationLimit, parts, robot, or_own=bool(self.ranges))
        self.velocity = _tightest(JointVelocityLimit, parts, robot, or_own=bool(self.ranges))
        limited = np.any([np.isfinite(own).any(axis=0) for own in self.ranges.values()], axis=0)
        if self.ranges and order == "acceleration" and np.isinf(self.acceleration[limited]).any():
            raise InvalidInput(
                f"{next(iter(self.ranges)).label()}: at acceleration order it needs to know how hard the joints can"
                " brake; add a JointAccelerationLimit(20.0), in rad/s^2, to the stack, or give the robot a limit"
            )
        self._bounds = [(lower, upper) for kind in RELAXED for part, lower, upper in rows if isinstance(part, kind)]
        if not self.ranges and np.isinf(self.acceleration).all():
            self._bounds = []  # velocity limits alone never contradict each other

    @property
    def brakes_blindly(self) -> bool:
        """Whether some acceleration is limited, and not the velocity from which to brake."""
        return bool((np.isfinite(self.acceleration) & np.isinf(self.velocity)).any())

    def braking_rate(self, tick: Tick) -> float:
        r"""The largest rate [1/s] at which a frame may near a bound, if the joints are to stop in time.

        Whatever the joints do, all of them can be slowed together, each by no more than its limit: along the same way,
        in the time :math:`T = \max_j v_j / a_j`, at first at the rate 1/T. A frame whose speed towards a bound is at
        most 1/T times its distance then stops before it, whichever bounds there are. v is the limit of the velocity,
        and where there is none the velocity within reach. The rate is infinite where nothing limits the acceleration.
        """
        braked = np.isfinite(self.acceleration)
        if tick.dt is None or not braked.any():
            return np.inf
        a = self.acceleration[braked]
        within = np.abs(tick.state.v[braked]) + a * tick.dt
        v = np.where(np.isfinite(self.velocity[braked]), self.velocity[braked], within)
        return 1.0 / (float((v / a).max()) + tick.dt)

    def reconcile(self, tick: Tick) -> None:
        """Relax the bounds of this tick in place, each just so far that it meets the harder ones."""
        if not self._bounds:
            return
        least, most = self._within_reach(tick)
        for lower, upper in self._bounds:
            np.minimum(lower, most, out=lower)
            np.maximum(upper, least, out=upper)
            least, most = np.maximum(least, lower), np.minimum(most, upper)

    def _within_reach(self, tick: Tick) -> tuple[Array, Array]:
        """What the acceleration limit leaves of x."""
        if tick.order == "acceleration":
            return -self.acceleration, self.acceleration
        assert tick.dt is not None  # checked before the first tick
        v, step = tick.state.v, self.acceleration * tick.dt
        return v - step, v + step


def _tightest(kind: type[SymmetricLimit], parts: list[Part], robot: Robot, *, or_own: bool) -> Array:
    """The smallest limit of this kind in every joint; the robot's own if there is none and it may stand in."""
    limits = [part for part in parts if isinstance(part, kind)]
    if not limits and or_own and limit_of(robot, kind.quantity) is not None:
        limits = [kind()]
    return np.min([limit.largest(robot) for limit in limits], axis=0) if limits else np.full(robot.nv, np.inf)
