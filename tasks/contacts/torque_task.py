r"""Task for the joint torques: with contacts, :math:`M_a a + b_a - G_a^T f = \tau^d`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import per_row
from ..base.live import number
from ..robots.robot import Robot, base, check_dynamics, joint_names, joint_units
from ..rows.expansion import Companions, Setting
from ..rows.part import Order, Part
from ..targets.trajectories import Trajectory, as_trajectory

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class TorqueTask(Part):
    """Bring the torques of all joints that have a motor to a target, or to zero: least torque, on the last level.

    Alone, it lets joints swing in the null space, as :class:`~tasks.MinimumTorqueTask` does: join a posture to it.

    Parameters
    ----------
    target : float, array, shape (nv - base,), or Trajectory
        Desired torques [N m], of prismatic joints forces [N].
    weight : float or array, shape (nv - base,)
        Weight of the rows inside their level; 0 leaves a joint out.
    name : str

    Raises
    ------
    InvalidInput
        With a robot, if it has no motion equation, has a floating base and the stack no Dynamics, or the order is
        velocity.

    Examples
    --------
    >>> from tasks import PositionTask, TorqueTask
    >>> PositionTask([0.3, 0.4, 0.2], gain=5.0) >> TorqueTask()
    PositionTask([0.3, 0.4, 0.2], gain=5) >> TorqueTask([0.0])
    """

    rows = None
    wide = True

    def __init__(
        self, target: ArrayLike | Trajectory = 0.0, *, weight: ArrayLike = 1.0, name: str = "joint torques"
    ) -> None:
        self.name = of_type(name, str, "name of a TorqueTask")
        self.weight, self.target = weight, target

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The desired torques [N m], forces [N]."""
        return as_trajectory(value, None, self.full_name())

    def size(self, robot: Robot) -> int:
        return robot.nv - base(robot)

    def companions(self, setting: Setting) -> Companions:
        if base(setting.robot) and not setting.has_dynamics:
            raise InvalidInput(
                f"{self.full_name()}: {setting.robot!r} has a floating base, which no joint torque drives; add"
                " Dynamics() and contacts to the stack"
            )
        return super().companions(setting)

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order != "acceleration":
            raise InvalidInput(
                f"{self.full_name()}: order = {order!r}; torques belong to accelerations: 'acceleration'"
            )
        check_dynamics(robot, self.full_name())
        sample = self.target(0.0)[0]
        if len(sample) != 1:
            per_row(sample, self.size(robot), f"{self.full_name()}: target", "joint with a motor")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        first = base(robot)
        rows = zip(joint_names(robot)[first:], joint_units(robot)[first:], strict=True)
        return [Label(self.name, joint, "N" if unit == "m" else "N m") for joint, unit in rows]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.forces import write_torques

        shared, target = site.shared, np.zeros((3, site.rows))
        moves = site.keep_up(self, "target", *target)
        M, b, first = shared.blocks.mass_matrix(), shared.blocks.bias(), base(shared.robot)
        assert site.A is not None
        told = shared.n, shared.unknowns.n, first, site.rows, M, b, shared.wrenches, site.A
        return Plan((Call(write_torques, *told, target, site.lower, site.upper),), moves)

    def __repr__(self) -> str:
        return f"TorqueTask({self.target!r})"
