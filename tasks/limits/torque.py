r"""Joint torque limits.

The torques that accelerations a take are :math:`\tau = M(q)\,a + b(q, v)` (Eq. 4.1), with b the Coriolis, centrifugal
and gravity torques. A limit on them is a limit on all accelerations together, one dense row a joint:

.. math:: -\tau_{max} - b(q, v) \;\le\; M(q)\,a \;\le\; \tau_{max} - b(q, v).

M is invertible: some a always keeps all rows, alone. Beside other limits it may not, and then the levels decide.

``JointTorqueLimit() >> JointLimits() >> tasks``
    What motors can do stands first, as in nature. A joint whose motors are too weak to brake overshoots its range, and
    ``explain()`` names the torque limit that held the joint limits back.
``JointLimits() >> JointTorqueLimit() >> tasks``
    The joints keep their ranges in the plan, which then asks for torques that no motor has: the command is to be cut,
    and the motion differs from the plan. For planning, where a torque limit is a wish.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, numbers, positive
from ..base.live import number
from ..robots.robot import Robot, check_dynamics, check_fixed_base, joint_names, joint_units
from ..rows.part import Order, Part
from .limit import largest

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class JointTorqueLimit(Part):
    """Bounds on the joint torques, at acceleration and at torque order.

    Parameters
    ----------
    limit : float or array, shape (nv,), optional
        Positive [N m], of a sliding joint [N]; None for the robot's own.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a limit is not positive; and, with a robot, if there is not one a joint, the order is velocity, the base
        floats, or the robot does not know its mass matrix.
    """

    is_limit: ClassVar[bool] = True
    limited: ClassVar[Literal["motion", "torque"] | None] = "torque"
    rows = None

    def __init__(self, limit: ArrayLike | None = None, *, name: str = "torque") -> None:
        self.name = of_type(name, str, "name of a JointTorqueLimit")
        self.weight = numbers(1.0, "weight")
        self.limit = limit

    @number
    def limit(self, value: ArrayLike | None) -> Array | None:
        """The largest torque of each joint [N m], [N], shape () or (nv,); None for the robot's own."""
        return None if value is None else positive(value, f"{self.label()}: limit", unit="N m")

    def largest(self, robot: Robot) -> Array:
        """The limit of each joint of this robot [N m], [N], shape (nv,); infinite where it has none.

        Raises
        ------
        InvalidInput
            If neither this limit nor the robot has a number, or there is not one a joint.
        """
        return largest(self, self.limit, robot, "torque", "N m")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        part = "torque limit" if self.name == "torque" else self.name
        joints = zip(joint_names(robot), joint_units(robot), strict=True)
        return [Label(part, joint, "N" if unit == "m" else "N m") for joint, unit in joints]

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order == "velocity":
            raise InvalidInput(
                f"{self.label()}: velocities tell no torques; the order of the controller must be 'torque' or"
                " 'acceleration'"
            )
        if order == "step":  # which takes none
            return
        check_fixed_base(robot, self.label())
        check_dynamics(robot, self.label())
        self.largest(robot)

    def plan(self, site: Site) -> Plan:
        """One loop, from the mass matrix and the bias of the tick; a step of inverse kinematics takes no torques."""
        from ..base.loops import Call
        from ..rows.plan import Plan, free
        from . import kernels as loops

        if site.shared.order == "step":
            return free(site)
        blocks, limit = site.shared.blocks, self.largest(site.shared.robot)
        assert site.A is not None
        told = site.shared.n, site.A, site.lower, site.upper, blocks.mass_matrix(), blocks.bias(), limit
        return Plan((Call(loops.write_torque_limit, *told),))

    def __repr__(self) -> str:
        return f"JointTorqueLimit({'' if self.limit is None else self.limit.tolist()})"
