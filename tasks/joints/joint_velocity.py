"""Task: desired joint velocities."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.checks import of_type

from ..base.checks import Array, per_row, positive
from ..base.live import number, structure
from ..robots.robot import Robot, RobotState, base, joint_names
from ..rows.alone import robot_of
from ..rows.part import Order, Part
from ..targets.trajectories import Trajectory, as_trajectory
from .posture import columns, named_joints

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class JointSpeeds(Part):
    """Base of the parts that give joints a speed: rows of the identity.

    Attributes
    ----------
    joints : tuple or None
        Names or numbers; None for all but those of a floating base.
    """

    plain = True
    rows = None
    joints: tuple[str | int, ...] | None = structure()

    def size(self, robot: Robot) -> int:
        return len(self.variables(robot))

    def variables(self, robot: Robot) -> NDArray[np.intp]:
        return columns(self.joints, joint_names(robot), base(robot))

    def speeds(self, site: Site, target: Array, gain: Array | None) -> Plan:
        """One loop: the wanted speeds and their rates, shape (2, rows); K of every row, None for 1/dt."""
        from ..base.loops import Call
        from ..rows.kernels.law import ORDERS
        from ..rows.plan import Plan
        from .kernels.speeds import write_speeds

        shared, own = site.shared, self.variables(site.shared.robot).astype(np.int64)
        if site.A is not None:
            site.A[:] = np.eye(shared.n)[own]
        if gain is None:
            gain = np.full(site.rows, np.nan if shared.dt is None else 1.0 / shared.dt)
        told = ORDERS.index(shared.order), site.rows, shared.n, own, shared.v, target, gain, site.lower, site.upper
        return Plan((Call(write_speeds, *told),), linear=True)


class JointVelocityTask(JointSpeeds):
    """Move joints at given speeds: v itself at velocity order, an acceleration towards v at acceleration order.

    ``JointVelocityTask([0.2], joints=["panda_joint1"])`` turns one joint, at 0.2 rad/s, as far as the levels above
    permit. Below other tasks it is a preferred motion: the speeds of a demonstration, or of the tick before. In
    inverse kinematics it asks for nothing.

    Parameters
    ----------
    target : float, array, shape (joints,), or Trajectory
        [rad/s], [m/s]; a trajectory gives speeds, their rates [rad/s^2], and a third value, which is ignored.
    joints : names or numbers, optional
        Default: all but those of a floating base.
    gain : float or array, shape (joints,), optional
        K [1/s] of acceleration order: the rate at which the speeds are taken up. Default: within the tick.
    weight : float or array, shape (joints,)
        Of the rows inside their level.
    name : str

    Raises
    ------
    InvalidInput
        If the target is not finite, or a gain not positive; with a robot, if the target does not fit the joints or it
        has no such joint; with a controller of acceleration order, if a gain is more than 2/dt, or neither is given.

    Examples
    --------
    >>> from tasks import Controller, JointVelocityTask, PlanarArm, Stack
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> stack = Stack(JointVelocityTask([0.2, -0.1], joints=[0, 2]))
    >>> Controller(arm, stack, dt=0.01)([0.4, 0.6, 0.3]).v.round(9).tolist()
    [0.2, 0.0, -0.1]
    """

    def __init__(
        self,
        target: ArrayLike | Trajectory,
        *,
        joints: Iterable[str | int] | None = None,
        gain: ArrayLike | None = None,
        weight: ArrayLike = 1.0,
        name: str = "joint velocity",
    ) -> None:
        self.name = of_type(name, str, "name of a JointVelocityTask")
        self.joints = named_joints(joints, f"{self.full_name()}: joints")
        self.target, self.gain, self.weight = target, gain, weight

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The speeds [rad/s], [m/s]: one for all joints, or one a joint; or a trajectory of them."""
        return as_trajectory(value, None, self.full_name())

    @number
    def gain(self, value: ArrayLike | None) -> Array | None:
        """K [1/s] of acceleration order, shape () or (joints,); None: within the tick."""
        return None if value is None else positive(value, f"{self.full_name()}: gain", unit="1/s")

    def decay_rate(self) -> float:
        """Half of K."""
        return 0.0 if self.gain is None else 0.5 * float(self.gain.max())

    def error(self, state: RobotState, t: float) -> Array:
        """Desired minus actual speeds, shape (joints,)."""
        return self.target(t)[0] - state.v[self.variables(robot_of(state))]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        rows, sample = self.size(robot), self.target(0.0)[0]
        if len(sample) != 1:
            per_row(sample, rows, f"{self.full_name()}: target", "joint")
        if self.gain is not None:
            gain = per_row(self.gain, rows, f"{self.full_name()}: gain", "joint")
            if order == "acceleration" and dt is not None and gain.max() * dt > 2.0 + 1e-9:
                raise InvalidInput(
                    f"{self.full_name()}: gain = {gain.max():g} 1/s makes the error grow from tick to tick of {dt:g} s;"
                    f" it must be at most {2.0 / dt:g}"
                )
        elif order == "acceleration" and dt is None:
            raise InvalidInput(
                f"{self.full_name()}: at acceleration order it needs a gain in 1/s, or the tick, dt in s"
            )

    def plan(self, site: Site) -> Plan:
        from dataclasses import replace

        from ..rows.plan import free

        if site.shared.order == "displacement":
            return free(site)
        target, rest = np.zeros((2, site.rows)), np.zeros(site.rows)
        moves = site.keep_up(self, "target", *target, rest)
        gain = None if self.gain is None else per_row(self.gain, site.rows, f"{self.full_name()}: gain")
        return replace(self.speeds(site, target, gain), moves=moves)

    def __repr__(self) -> str:
        joints = "" if self.joints is None else f", joints={list(self.joints)}"
        return f"JointVelocityTask({self.target!r}{joints})"
