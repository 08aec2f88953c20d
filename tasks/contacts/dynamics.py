r"""The motion equation, which couples accelerations and contact forces.

.. math:: M(q)\, a + b(q, v) = S^T \tau + G^T f + \textstyle\sum_k J_k^T w_k,

with the joint torques tau, which are not bounded here, the forces f of all contacts, and measured wrenches :math:`w_k`.
If the viscous damping D of the joints is given, :math:`D v` is part of b.
No motor drives a floating base: its rows,

.. math:: (M_u, -G_u^T)\, (a, f) = -b_u + \dots,

tie its motion to the forces. The torques follow: :math:`\tau = M_a a + b_a - G_a^T f - \dots`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput, Label
from hqp.checks import of_type

from ..base.checks import Array, fill, finite_scalar, not_negative, numbers, pair, per_row, scalar
from ..base.live import number
from ..base.telling import tell
from ..robots.robot import (
    Robot,
    base,
    check_dynamics,
    check_frame,
    check_motors,
    joint_index,
    joint_names,
    joint_units,
)
from ..rows.expansion import Companions, Setting
from ..rows.part import Order, Part
from ..rows.site import Move
from .loop import Loop
from .model import ContactModel

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site

#: Function of time [s] that gives a wrench.
Sensor = Callable[[float], ArrayLike]


class Dynamics(Part):
    """The motion equation, with the forces of all contacts as unknowns.

    Parameters
    ----------
    wrenches : dict of frame to array, shape (6,), or to a function of time that gives one, optional
        Measured force [N] and moment [N m] on the robot at the origin of each frame, in the axes of the world.
    joint_damping : float or array, shape (nv,), optional
        D, viscous damping of the joints [N m s/rad], [N s/m], as ``robot.model.damping``; one number is for all joints
        but the base (default: none, feedback compensates what there is).
    springs : dict of joint to (float, float), optional
        Springs of joints, as ``robot.springs``: stiffness [N m/rad], [N/m], and position without force [rad], [m].
    weight : float or array, shape (base,)
        Weight of the rows inside their level.
    name : str

    Raises
    ------
    InvalidInput
        If a wrench does not have six numbers, or damping or stiffness is negative; with a robot, if the robot has no
        motion equation, no such frame or joint with a position, there is not one damping a joint, or the order is
        velocity.

    Examples
    --------
    >>> from tasks import Contact, Dynamics
    >>> Dynamics() + Contact("left_ankle_roll_link", plane=(0.2, 0.1), friction=0.6, name="left foot")
    Dynamics() + Contact('left_ankle_roll_link', friction=0.6, name='left foot')
    """

    is_dynamics: ClassVar[bool] = True
    wide = True

    def __init__(
        self,
        wrenches: Mapping[str, ArrayLike | Sensor] | None = None,
        *,
        joint_damping: ArrayLike | None = None,
        springs: Mapping[str, tuple[float, float]] | None = None,
        weight: ArrayLike = 1.0,
        name: str = "dynamics",
    ) -> None:
        self.name = of_type(name, str, "name of a Dynamics")
        self.weight, self.wrenches, self.joint_damping, self.springs = weight, wrenches, joint_damping, springs

    @number
    def wrenches(self, value: Mapping[str, ArrayLike | Sensor] | None) -> dict[str, Sensor]:
        """External wrenches on the robot, by frame."""
        given = of_type({} if value is None else value, Mapping, f"{self.full_name()}: wrenches")
        return {frame: self._sensor(frame, wrench) for frame, wrench in given.items()}

    @number
    def joint_damping(self, value: ArrayLike | None) -> Array | None:
        """Viscous damping of the joints, shape () or (nv,) [N m s/rad], [N s/m]; None for none."""
        return None if value is None else not_negative(value, f"{self.full_name()}: joint damping", unit="N m s/rad")

    @number
    def springs(self, value: Mapping[str, tuple[float, float]] | None) -> dict[str, tuple[float, float]]:
        """Springs of joints: stiffness [N m/rad], [N/m], and position without force [rad], [m]."""
        what = f"{self.full_name()}: springs"
        found = {}
        for joint, spring in of_type({} if value is None else value, Mapping, what).items():
            stiffness, rest = pair(spring, f"{what} of {joint!r}", "stiffness and rest")
            own = f"{what} of {joint!r}"
            found[joint] = scalar(not_negative(stiffness, own, unit="N m/rad"), own), finite_scalar(rest, own)
        return found

    def _springs(self, robot: Robot) -> NDArray[np.int64]:
        """The velocity of every joint with a spring."""
        names = joint_names(robot)
        return np.array([joint_index(names, joint, f"{self.full_name()}: springs") for joint in self.springs], np.int64)

    def _damping(self, robot: Robot) -> Array:
        """D of every velocity, shape (nv,)."""
        if self.joint_damping is None:
            return np.zeros(robot.nv)
        D = per_row(self.joint_damping, robot.nv, f"{self.full_name()}: joint damping", "joint")
        return D if self.joint_damping.ndim else np.where(np.arange(robot.nv) < base(robot), 0.0, D)

    def _sensor(self, frame: str, wrench: ArrayLike | Sensor) -> Sensor:
        sample = numbers(wrench(0.0) if callable(wrench) else wrench, f"{self.full_name()}: wrench at {frame!r}")
        if sample.shape != (6,):
            raise InvalidInput(f"{self.full_name()}: wrench at {frame!r} has shape {sample.shape}; it must be (6,)")
        return wrench if callable(wrench) else _Constant(sample)

    def size(self, robot: Robot) -> int:
        return base(robot)

    def companions(self, setting: Setting) -> Companions:
        if setting.order == "displacement":  # a step of the joints has no forces
            return Companions(())
        others = [part for part in setting.parts if isinstance(part, Part) and part is not self]
        alone = not any(isinstance(part, ContactModel | Loop) for part in others)
        if setting.order != "velocity" and not any(part.limited == "torque" for part in others):
            check_motors(setting.robot, self.full_name())
        if base(setting.robot) and alone:
            tell(f"{self.full_name()}: {setting.robot!r} has a floating base and no contact in its stack; it falls")
        return super().companions(setting)

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        if order == "velocity":
            raise InvalidInput(
                f"{self.full_name()}: velocities tell no forces; the order of the controller must be 'torque' or"
                " 'acceleration', or the contacts be without Dynamics()"
            )
        check_dynamics(robot, self.full_name())
        self._damping(robot)
        self._springs(robot)
        for frame in self.wrenches:
            check_frame(robot, frame, f"{self.full_name()}: wrench at")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        size = self.size(robot)
        rows = zip(joint_names(robot)[:size], joint_units(robot)[:size], strict=True)
        return [Label(self.name, joint, "N" if unit == "m" else "N m") for joint, unit in rows]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .bearing import bearing_calls
        from .kernels.dynamics import add_damping, add_springs, add_wrench, write_dynamics

        shared = site.shared
        M, b = shared.blocks.mass_matrix(), shared.blocks.bias()
        moves: list[Move] = []
        acting = shared.given.setdefault(id(self), [])
        acting.clear()
        if self.joint_damping is not None:
            acting.append(Call(add_damping, shared.n, self._damping(shared.robot), shared.v, b))
        if self.springs:
            own = self._springs(shared.robot)
            places, (K, rest) = shared.position_indices[own], np.array(list(self.springs.values())).T
            if (places < 0).any():
                joint = list(self.springs)[int(np.argmin(places))]
                raise InvalidInput(f"{self.full_name()}: springs: joint {joint!r} has no position of its own")
            numbers_of = own, np.ascontiguousarray(places), np.ascontiguousarray(K), np.ascontiguousarray(rest)
            acting.append(Call(add_springs, len(own), *numbers_of, shared.positions, b))
        for frame, sensor in self.wrenches.items():
            wrench = np.zeros(6)
            moves.append(_kept_up(wrench, sensor, f"{self.full_name()}: wrench at {frame!r}"))
            acting.append(Call(add_wrench, shared.n, shared.blocks.frame(frame), wrench, b))
        assert site.A is not None
        told: tuple[Any, ...] = (shared.n, shared.unknowns.n, 0, site.rows, M, b, shared.wrenches, site.A)
        rows = Call(write_dynamics, *told, site.lower, site.upper)
        return Plan((rows, *bearing_calls(shared)), tuple(moves))

    def __repr__(self) -> str:
        return f"Dynamics({', '.join(map(repr, self.wrenches))})"


class _Constant:
    """A constant wrench."""

    def __init__(self, wrench: Array) -> None:
        self._wrench = wrench

    def __call__(self, t: float, /) -> Array:
        return self._wrench


def _kept_up(place: Array, sensor: Sensor, what: str) -> Move:
    def move(t: float) -> None:
        fill(place, sensor(t), what)

    move(0.0)
    return move
