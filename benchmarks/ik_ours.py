"""The methods of this library in ``python -m benchmarks ik``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hqp.arrays import Array
from tasks import OrientationTask, PoseTask, PositionTask, PostureTask, Stack, solve_ik

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: When a pose counts as reached [m], [rad].
TOLERANCE = (1e-4, 1e-3)


@dataclass(frozen=True)
class Target:
    """A pose of the tip, and the number of its draw."""

    position: Array
    rotation: Array
    seed: int


@dataclass(frozen=True)
class Outcome:
    """The result of a method for one target: whether it was reached, steps, largest excess over a limit."""

    reached: bool
    steps: int
    beyond: float


class Method(ABC):
    """A name, and a way to a pose from the home configuration.

    Parameters
    ----------
    robot : PinocchioRobot
    restarts : bool
        Whether to begin anew from random configurations where it is stuck.
    """

    name: str
    package: str = "numpy"

    def __init__(self, robot: PinocchioRobot, restarts: bool) -> None:
        self.robot, self.restarts = robot, restarts

    @abstractmethod
    def solve(self, target: Target, budget: int) -> Outcome:
        """Go to the pose in at most so many steps."""


class Native(Method):
    """``solve_ik``, construction of tasks and hierarchy included; position and orientation on one level."""

    name = "native"

    def stack(self, target: Target) -> Stack:
        """The tasks, in order of priority."""
        return Stack(PoseTask(target.position, target.rotation, gain=1.0))

    def solve(self, target: Target, budget: int) -> Outcome:
        found = solve_ik(
            self.robot,
            self.stack(target),
            tolerance=TOLERANCE,
            iterations=budget,
            restarts=self.restarts,
            settle=False,
            seed=target.seed,
        )
        return Outcome(found.reached, found.iterations, beyond(self.robot, found.q))


class NativeStrict(Native):
    """Position above orientation."""

    name = "native, strict"

    def stack(self, target: Target) -> Stack:
        return PositionTask(target.position, gain=1.0) >> OrientationTask(target.rotation, gain=1.0)


class NativePosture(NativeStrict):
    """The same, with a posture as the third level."""

    name = "native, posture"

    def stack(self, target: Target) -> Stack:
        return super().stack(target) >> PostureTask(self.robot.home, gain=1.0)


def beyond(robot: PinocchioRobot, q: Array) -> float:
    """By how much a joint is outside its range at most [rad]; 0 inside."""
    assert robot.position_limit is not None
    low, high = robot.position_limit
    return max(0.0, float(np.maximum(low - q, q - high).max()))
