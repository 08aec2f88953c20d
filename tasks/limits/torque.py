r"""Joint torque limits.

The torques needed for accelerations a are :math:`\tau = M(q)\,a + b(q, v)` (Eq. 4.1), with b the Coriolis, centrifugal
and gravity torques. A limit on them is a limit on all accelerations together, one dense row a joint:

.. math:: -\tau_{max} - b(q, v) \;\le\; M(q)\,a \;\le\; \tau_{max} - b(q, v).

M is invertible, so that torque limits alone can always be kept. Beside other limits they may not: priorities decide.

With contacts and :class:`~tasks.Dynamics` in the stack, whose forces f are unknowns too,
:math:`\tau = M a + b - G^T f`: the rows are :math:`(M, -G^T)`, and a base that floats, which no motor drives, has none.

``JointTorqueLimit() >> JointLimits() >> tasks``
    The limits of the motors have priority, as in reality. A joint whose motors are too weak to brake leaves its range;
    ``explain()`` names the torque limit that held the joint limits back.
``JointLimits() >> JointTorqueLimit() >> tasks``
    The joints keep their ranges in the plan, which then asks for torques that no motor has: the command is to be cut,
    and the motion differs from the plan. For planning, where a torque limit is not a hard one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, limits, not_negative, numbers, pair, per_row
from ..base.live import number
from ..robots.robot import Robot, base, check_dynamics, joint_names, joint_units, limit_of
from ..rows.part import Order, Part
from .limit import largest

if TYPE_CHECKING:
    from ..rows.expansion import Companions, Setting
    from ..rows.plan import Plan
    from ..rows.site import Site


class JointTorqueLimit(Part):
    """Bounds on the joint torques, at acceleration and at torque order.

    Parameters
    ----------
    limit : float or array, shape (nv,), optional
        [N m], of a sliding joint [N], 0 of a joint without a motor, infinite of one without limit; one number is for
        all joints that have a motor, and None for the robot's own.
    speeds : pair of float or array, shape (nv,), optional
        Joint speeds [rad/s], [m/s] up to which a motor gives all of its torque in the direction in which it turns, and
        from which on none; between them it falls in proportion. Against its direction, braking, it gives all.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a limit is negative, or the first speed not below the second; and, with a robot, if there is not one a
        joint, the order is velocity, the base floats and the stack has no :class:`~tasks.Dynamics`, or the robot does
        not know its mass matrix.

    Examples
    --------
    >>> from tasks import Controller, JointTorqueLimit, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5], masses=[1.0, 1.0, 1.0])
    >>> stack = JointTorqueLimit(2.0) >> PositionTask([1.0, 0.2], gain=5.0)
    >>> Controller(arm, stack, order="torque", dt=0.01)([1.1, -1.3, -0.7], [0.0, 0.0, 0.0]).tau.round(3)
    array([2.   , 1.991, 0.564])
    """

    is_limit: ClassVar[bool] = True
    reads_limits: ClassVar[bool] = True
    limited: ClassVar[Literal["motion", "torque"] | None] = "torque"
    rows = None
    wide = True

    def __init__(
        self,
        limit: ArrayLike | None = None,
        *,
        speeds: tuple[ArrayLike, ArrayLike] | None = None,
        name: str = "torque",
    ) -> None:
        self.name = of_type(name, str, "name of a JointTorqueLimit")
        self.weight = numbers(1.0, "weight")
        self.limit, self.speeds = limit, speeds

    @number
    def limit(self, value: ArrayLike | None) -> Array | None:
        """The largest torque of each joint [N m], [N], shape () or (nv,), 0 without a motor; None for the robot's."""
        if value is None:
            return None
        return limits(value, f"{self.full_name()}: limit", unit="N m", zero_holds=True)

    @number
    def speeds(self, value: tuple[ArrayLike, ArrayLike] | None) -> tuple[Array, Array] | None:
        """Joint speeds up to which motors give all of their torque, and from which on none [rad/s], [m/s]."""
        if value is None:
            return None
        what = f"{self.full_name()}: speeds"
        full, none = (not_negative(speed, what, unit="rad/s") for speed in pair(value, what, "all and no torque"))
        if not np.all(full < none):
            raise InvalidInput(f"{what} = {full.tolist()}, {none.tolist()}; the first must be below the second")
        return full, none

    def largest(self, robot: Robot) -> Array:
        """The limit of each joint of this robot [N m], [N], shape (nv,); infinite where it has none.

        Raises
        ------
        InvalidInput
            If neither this limit nor the robot has a number, or there is not one a joint.
        """
        limits, own = largest(self, self.limit, robot, "torque", "N m"), limit_of(robot, "torque")
        if own is not None and self.limit is not None and not self.limit.ndim:
            return np.where(own == 0.0, 0.0, limits)  # one number is for all joints that have a motor
        return limits

    def size(self, robot: Robot) -> int:
        return robot.nv - base(robot)

    def companions(self, setting: Setting) -> Companions:
        if setting.order == "acceleration" and base(setting.robot) and not setting.has_dynamics:
            raise InvalidInput(
                f"{self.full_name()}: {setting.robot!r} has a floating base, which no joint torque drives; add"
                " Dynamics() and contacts to the stack"
            )
        return super().companions(setting)

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        part, first = "torque limit" if self.name == "torque" else self.name, base(robot)
        joints = zip(joint_names(robot)[first:], joint_units(robot)[first:], strict=True)
        return [Label(part, joint, "N" if unit == "m" else "N m") for joint, unit in joints]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order == "velocity":
            raise InvalidInput(
                f"{self.full_name()}: velocities tell no torques; the order of the controller must be 'torque' or"
                " 'acceleration'"
            )
        if order == "displacement":  # which takes none
            return
        check_dynamics(robot, self.full_name())
        self._speeds(robot)
        largest = self.largest(robot)[base(robot) :]
        if np.isinf(largest).all():
            raise InvalidInput(
                f"{self.full_name()}: the model of {robot!r} has no effort limits; give some in N m:"
                " JointTorqueLimit(50.0)"
            )

    def _speeds(self, robot: Robot) -> Array:
        """Both speeds of every joint [rad/s], [m/s], shape (2, nv); infinite where torques do not fade."""
        if self.speeds is None:
            return np.full((2, robot.nv), np.inf)
        return np.array([per_row(speed, robot.nv, f"{self.full_name()}: speeds", "joint") for speed in self.speeds])

    def plan(self, site: Site) -> Plan:
        """One loop, from the mass matrix and the bias of the tick; a step of inverse kinematics takes no torques."""
        from ..base.loops import Call
        from ..rows.plan import Plan, free
        from . import kernels as loops

        if site.shared.order == "displacement":
            return free(site)
        shared = site.shared
        blocks, first = shared.blocks, base(shared.robot)
        limit = np.ascontiguousarray(self.largest(shared.robot)[first:])
        assert site.A is not None
        motion = shared.n, shared.unknowns.n, first, site.rows, blocks.mass_matrix(), blocks.bias(), shared.wrenches
        fading = np.ascontiguousarray(self._speeds(shared.robot)[:, first:])
        own = site.A, site.lower, site.upper, limit, fading, shared.v
        return Plan((Call(loops.write_torque_limit, *motion, *own),))

    def __repr__(self) -> str:
        return f"JointTorqueLimit({'' if self.limit is None else self.limit.tolist()})"
