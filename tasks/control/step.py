"""The output of a controller for one tick: motion, torques, contact forces, and how well every level is met."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, NamedTuple

from hqp import Solution
from hqp.solution import Relaxation

from ..robots.robot import RobotState
from ..rows.part import Command
from . import contacts as of

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    Velocity = TypeVar("Velocity", default=Any)
    Acceleration = TypeVar("Acceleration", default=Any)
    Torque = TypeVar("Torque", default=Any)
else:
    from typing import TypeVar

    #: Types of v, a and tau of a step: arrays or None, depending on the order of the controller. If the order is known
    #: only at run time, either is possible.
    Velocity, Acceleration, Torque = TypeVar("Velocity"), TypeVar("Acceleration"), TypeVar("Torque")


class Step(NamedTuple, Generic[Velocity, Acceleration, Torque]):
    """The output of a controller for one tick: the command, and the solution it comes from.

    Attributes
    ----------
    order : {"velocity", "acceleration", "torque"}
    state : RobotState
        The state of the robot at this tick.
    solution : hqp.Solution
        How well every level is met; ``.certify().ok`` is the proof.
    v : array, shape (nv,), or None
        Joint velocities [rad/s], [m/s], at velocity order. Those of a floating base, the first six, are its linear and
        angular velocity along its own axes.
    a : array, shape (nv,), or None
        Joint accelerations [rad/s^2], at acceleration and at torque order.
    tau : array, shape (nv,), or None
        Joint torques ``M(q) a + b(q, v)`` [N m] for a (Eq. 4.1), at torque order or if they were asked for; with
        :class:`tasks.Dynamics` in the stack ``M a + b - G^T f``, of the joints that have a motor, shape (nv - base,).
        Always finite: zero if the status of the solution is INVALID, and then an arm falls.
    share : float
        Share of the present stack in the command: less than 1 while the controller changes to it from another one.
        Then v or a lies between the answers of both stacks, and `solution` is that of the new one alone.
    forces : Forces or None
        Forces of the world on the robot, by the names of the contacts: ``forces["left"]``, in world axes [N].
    """

    order: Command
    state: RobotState
    solution: Solution
    v: Velocity = None  # type: ignore[assignment]
    a: Acceleration = None  # type: ignore[assignment]
    tau: Torque = None  # type: ignore[assignment]
    share: float = 1.0
    forces: of.Forces | None = None

    @property
    def cop(self) -> of.Pressures | None:
        """Centres of pressure by the names of the contacts, in the coordinates of their frames [m]."""
        return None if self.forces is None else of.Pressures(self.forces)

    @property
    def ok(self) -> bool:
        """Whether the solver reports an optimum; if not, ``solution`` shows why."""
        return self.solution.ok

    @property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """Levels that were relaxed by damping: lambda and residual norm of each, highest first."""
        return self.solution.relaxed
