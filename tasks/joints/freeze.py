"""Constraint: joints that do not move."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.live import structure
from ..robots.robot import Robot, joint_names
from ..rows.part import Order
from .joint_velocity import JointSpeeds
from .posture import columns, named_joints

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class Freeze(JointSpeeds):
    """Keep joints from moving, exactly: rows x = 0, to be put above the tasks that would move them.

    ``JointLimits() >> Freeze(["torso_lift_joint"]) >> reach`` reaches with all joints but one, and
    ``Freeze(all_but=left_arm)`` with a group of joints and no others. At acceleration order a moving joint stops within
    a tick, as far as the levels above permit. Joints that are always held are better left out of the robot:
    ``load_robot(..., lock=[...])``.

    Parameters
    ----------
    joints : names or numbers, optional
        The joints to be held; components of a floating base are joints too, as in ``"root_joint[2]"``.
    all_but : names or numbers, optional
        In place of `joints`: those that may move, all others are held.
    weight : float or array, shape (joints,)
        Of the rows inside their level; 0 lets a joint go.
    name : str

    Raises
    ------
    InvalidInput
        If neither or both are given; with a robot, if it has no such joint or none is left; and at acceleration order,
        if the controller has no dt.

    Examples
    --------
    >>> from tasks import Controller, Freeze, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> controller = Controller(arm, Freeze([1]) >> PositionTask([1.0, 0.6], gain=2.0), dt=0.01, damping=None)
    >>> float(controller([0.4, 0.6, 0.3]).v[1])
    0.0
    """

    is_limit: ClassVar[bool] = True
    all_but: tuple[str | int, ...] | None = structure()

    def __init__(
        self,
        joints: Iterable[str | int] | None = None,
        *,
        all_but: Iterable[str | int] | None = None,
        weight: ArrayLike = 1.0,
        name: str = "frozen joints",
    ) -> None:
        self.name = of_type(name, str, "name of a Freeze")
        if (joints is None) == (all_but is None):
            raise InvalidInput(f"{self.full_name()}: give the joints to hold, or all_but= those that may move")
        self.joints = named_joints(joints, f"{self.full_name()}: joints", some=False)
        self.all_but = named_joints(all_but, f"{self.full_name()}: all_but", some=False)
        self.weight = weight

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        names = joint_names(robot)
        if self.all_but is None:
            return columns(self.joints, names, 0)
        return np.delete(np.arange(robot.nv), columns(self.all_but, names, 0))

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if not self.size(robot):
            raise InvalidInput(f"{self.full_name()}: no joint of {robot!r} is held; name one")
        if order == "acceleration" and dt is None:
            raise InvalidInput(
                f"{self.full_name()}: at acceleration order it needs the tick; give the controller dt in s"
            )

    def plan(self, site: Site) -> Plan:
        return self.speeds(site, np.zeros((2, site.rows)), None)

    def __repr__(self) -> str:
        held = list(self.joints or ())
        return f"Freeze({held})" if self.all_but is None else f"Freeze(all_but={list(self.all_but)})"
