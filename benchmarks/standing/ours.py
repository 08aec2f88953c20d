"""Drivers of this library for a robot that stands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hqp import Hierarchy, Solver, certify
from hqp.arrays import Array
from tasks import Controller, Step

from ..ticks.driver import Driver
from .scenes import DT, declare
from .stream import StandingStream, restore, workspace

if TYPE_CHECKING:
    from tasks.robots.pinocchio_state import PinocchioState


class Standing(Driver):
    """A driver that is given the rows of this library, all but the controller itself.

    Attributes
    ----------
    hierarchy : Hierarchy
        The rows of the last tick.
    hard : int
        How many levels stand above the task in question: physics and limits.
    """

    stream: StandingStream  # type: ignore[assignment]

    def __init__(self, name: str, stream: StandingStream) -> None:
        super().__init__(name, stream)  # type: ignore[arg-type]
        self.robot = stream.robot
        self.declared = declare(stream.scene, self.robot)
        self.rows = self.declared.stack.build(self.robot, "acceleration", DT)
        self.hierarchy: Hierarchy = self.rows.hierarchy
        levels = enumerate(self.rows.levels.parts)
        self.hard = next(k for k, parts in levels if self.declared.center_of_mass in parts)
        self.q, self.v = list(stream.q), list(stream.v)
        feet = stream.contacts
        self.numbers = [{foot: feet[foot][k] for foot in feet} for k in range(len(stream))]

    @property
    def unknowns(self) -> int:
        return self.hierarchy.n

    def state(self, k: int) -> PinocchioState:
        """The robot at tick k, its kinematics and its motion equation known."""
        return self.robot.at(self.q[k], self.v[k])

    def fill(self, k: int, state: PinocchioState) -> Hierarchy:
        """The rows of tick k."""
        restore(self.declared.contacts, self.rows.shared, self.numbers[k])
        return self.rows.fill(state, k * DT)

    def proved(self, k: int, v: Array) -> bool:
        return bool(np.isfinite(v).all()) and certify(self.fill(k, self.state(k)), v).ok


class OursStanding(Standing):
    """A :class:`tasks.Controller` at torque order, called as a user would."""

    def __init__(self, stream: StandingStream, *, name: str = "hqp") -> None:
        super().__init__(name, stream)
        self.controller = Controller(self.robot, self.declared.stack, order="torque", dt=DT)
        self.solver = Solver()

    def tick(self, k: int) -> Step[None, Array, Array]:
        restore(self.declared.contacts, workspace(self.controller), self.numbers[k])
        return self.controller(self.q[k], self.v[k], k * DT)

    def stages(self, k: int) -> Iterator[None]:
        state = self.state(k)
        state.accelerated()
        yield
        hierarchy = self.fill(k, state)
        yield
        self.solver.solve(hierarchy)
        yield

    def velocity(self, answer: Step[None, Array, Array]) -> Array:
        return answer.solution.x
