"""Builds the state of a robot from the numbers of a tick: never raises, and admits one thread at a time."""

from __future__ import annotations

from hqp.guard import Guard

from ..base.checks import Array
from ..robots.robot import Robot, RobotState, check_states, workspace


class StateReader:
    """Gives the states of one robot.

    It checks configurations on a manifold itself, so that a controller never raises for a state.

    Parameters
    ----------
    robot : Robot

    Attributes
    ----------
    guard : hqp.guard.Guard
        Hold it as long as a state is in use. If the states of the robot share a workspace, it is the robot's guard,
        common to all its controllers.
    """

    def __init__(self, robot: Robot) -> None:
        check_states(robot)
        shared = workspace(robot)
        self._on_manifold = None if shared is None else shared.on_manifold
        self._state = robot.at if shared is None else shared.state
        self.guard = Guard("the controller") if shared is None else shared.guard

    def read(self, q: Array, v: Array) -> tuple[RobotState, str | None]:
        """The state, and the error message if q is not on its manifold, else None."""
        fault = None
        if self._on_manifold is not None:
            q, fault = self._on_manifold(q)
        return self._state(q, v), fault
