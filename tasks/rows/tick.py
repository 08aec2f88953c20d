"""The state and settings of one call of a controller, as its parts get them; the orders of control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..robots.robot import Robot, RobotState
from .envelope import Envelope

#: What the unknown x of the hierarchy is: joint velocities [rad/s], joint accelerations [rad/s^2], or joint
#: displacements [rad], the Newton step of inverse kinematics.
Order = Literal["velocity", "acceleration", "displacement"]
#: What a controller commands. Torques [N m] are those of the accelerations: below them the order is "acceleration".
Command = Literal["velocity", "acceleration", "torque"]
#: What follows the unit of a position, in the unit of x.
PER: dict[str, str] = {"velocity": "/s", "acceleration": "/s^2", "displacement": ""}


@dataclass(frozen=True, slots=True)
class Tick:
    """One call of the controller.

    Parameters
    ----------
    robot : Robot
    state : RobotState
        The robot at (q, v).
    t : float
        The time [s].
    order : {"velocity", "acceleration", "displacement"}
        What x is.
    dt : float or None
        The time between two calls [s].
    envelope : Envelope, optional
        What the joint limits of the stack know of each other.
    """

    robot: Robot
    state: RobotState
    t: float
    order: Order
    dt: float | None
    envelope: Envelope | None = None
