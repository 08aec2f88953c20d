r"""The rows of one Newton step of a stack, and the bounds of that step.

Its rows are those of order "displacement" (:mod:`tasks.rows.kernels.law`): a task asks for its whole error, and an
inequality allows the whole distance to its bounds; gains and the motion of targets have no effect. Of the joint limits
only the ranges are used. They hold exactly, above all levels, together with a trust region of radius r:

.. math:: \max(q_{min} - q, -r) \le x \le \min(q_{max} - q, r)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hqp import InvalidInput, Label, Side

from ..base.checks import Array, numbers
from ..frames.limits import FrameVelocityLimit
from ..limits.joint_limits import JointLimits
from ..limits.limit import JointLimit
from ..limits.position import JointPositionLimit
from ..robots.robot import Robot, joint_names, joint_units, limit_of
from ..rows.levels import Levels
from ..rows.part import Order, Part, Stack
from ..rows.row_writer import RowWriter

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site

#: Radius [rad], [m] of the first trust region, the largest, and that of the last step, which explains what is at rest.
RADIUS = 2.0
#: Relative tolerance within which a bound is that of the trust region.
SAME = 1e-12
#: Name of a bound that is not a joint limit.
TRUST_REGION = "trust region"
#: Parts that are left out: they limit speeds, or :func:`ranges` reads them.
DROPPED = (JointLimit, JointLimits, FrameVelocityLimit)


class Room(Part):
    """Bounds of one Newton step: the joint ranges and the trust region.

    Parameters
    ----------
    low, high : array, shape (nv,)
        The ranges [rad], [m].
    """

    plain = True
    rows = None

    def __init__(self, low: Array, high: Array) -> None:
        self.low, self.high = np.ascontiguousarray(low), np.ascontiguousarray(high)
        self._reach = np.array([np.inf, 1.0])
        self.name, self.weight = "joint limits", numbers(1.0, "weight")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        joints = zip(joint_names(robot), joint_units(robot), strict=True)
        return [Label("position limit", joint, unit, which) for joint, unit in joints]

    def plan(self, site: Site) -> Plan:
        """No loop: the bounds depend on the errors at the state, and are written by :meth:`open`."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.steps import open_room

        shared = site.shared
        places = shared.position_indices.astype(np.int64)
        self._call = Call(
            open_room, shared.n, shared.positions, places, self.low, self.high, self._reach, site.lower, site.upper
        )
        return Plan()

    def open(self, radius: float, share: float) -> None:
        """Write the bounds at the present joints: a share of the distances to the limits, within the radius."""
        self._reach[:] = radius, share
        self._call.run()


def which(side: Side, bound: float) -> str:
    """Which limit a bound of the last step is."""
    return TRUST_REGION if abs(bound) >= RADIUS * (1.0 - SAME) else "position limit"


def levels_of_steps(stack: Stack, levels: Levels) -> list[list[RowWriter]]:
    """The levels of a stack that are solved, without limits of joints and speeds.

    Raises
    ------
    InvalidInput
        If the stack has only limits.
    """
    kept = [[part for part in level if not isinstance(part, DROPPED)] for level in levels.parts]
    if not any(kept):
        raise InvalidInput(f"the stack {stack!r} has limits only; inverse kinematics needs a task")
    return [level for level in kept if level]


def ranges(robot: Robot, levels: Levels) -> Array:
    """Lowest and highest position of every joint, shape (2, nv): the robot's own and those of the stack together.

    Raises
    ------
    InvalidInput
        If a joint has no range left.
    """
    own = limit_of(robot, "position")
    low, high = np.array([[-np.inf], [np.inf]]).repeat(robot.nv, axis=1) if own is None else np.array(own)
    for part in levels.all_parts:
        for limit in part.limits if isinstance(part, JointLimits) else (part,):
            if isinstance(limit, JointPositionLimit):
                least, most = limit.range(robot)
                low, high = np.maximum(low, least), np.minimum(high, most)
    if (low > high).any():
        joint = int(np.argmax(low > high))
        raise InvalidInput(
            f"position limits of {joint_names(robot)[joint]}: the robot and the stack leave it from {low[joint]:g}"
            f" to {high[joint]:g} {joint_units(robot)[joint]}; the lowest must not be above the highest"
        )
    return np.array([low, high])
