"""Recorded ticks as pairs of hierarchies: that of the tick, and that of the tick before."""

from __future__ import annotations

from functools import cache
from typing import Any

from hqp import Hierarchy, InvalidInput
from tasks import Robot, Stack
from tasks.thesis.laws import LIMITS, SWAPPED, TIP_LIMITS, Law
from tasks.thesis.scenarios import Scenario, scenario

from ..families.family import Sample
from ..ticks.scenes import Scene
from ..ticks.stack import Targets, declare
from . import arms, humanoids
from .data import Ticks, ticks

#: By the name of their family.
SCENES: dict[str, Scene] = {scene.name: scene for scene in (*arms.SCENES, *humanoids.SCENES)}
#: By the name of their family: a figure of the thesis, and the law by which the arm moves.
FIGURES: dict[str, tuple[str, Law]] = {
    "line": ("4.7", LIMITS),
    "rectangle": ("4.11", LIMITS),
    "triangle": ("4.19", LIMITS),
    "circle": ("4.23", LIMITS),
    "inclined 3R": ("4.27", LIMITS),
    "inclined 4R": ("4.33", LIMITS),
    "orientation first": ("4.3", SWAPPED),
    "tip alone": ("4.26", TIP_LIMITS),
}


class Played:
    """Recorded ticks, given to the stack that they were recorded with.

    Parameters
    ----------
    robot : Robot
    stack : Stack
    order : {"velocity", "acceleration"}
    dt : float
        Tick [s].
    recorded : dict of str to array, shape (draws, 2, ...)
        Of each tick before, and of each tick: ``q``, ``v``, the time ``t``, and ``positions/FRAME``,
        ``rotations/FRAME`` where targets are set from outside.
    targets : Targets, optional
        Those that are.
    """

    def __init__(
        self, robot: Robot, stack: Stack, order: Any, dt: float, recorded: Ticks, targets: Targets | None = None
    ) -> None:
        self.robot, self.rows, self.recorded = robot, stack.build(robot, order, dt), recorded
        self.targets = [
            (getattr(targets, kind)[frame], values)
            for key, values in recorded.items()
            for kind, _, frame in [key.partition("/")]
            if frame
        ]

    def __len__(self) -> int:
        return len(self.recorded["q"])

    def sample(self, draw: int) -> Sample:
        """The hierarchies of one tick and of the tick before it.

        Raises
        ------
        InvalidInput
            If not so many ticks were recorded.
        """
        if not 0 <= draw < len(self):
            raise InvalidInput(f"draw = {draw}; there are the draws 0 .. {len(self) - 1}")
        return Sample(self._hierarchy(draw, 0), self._hierarchy(draw, 1))

    def _hierarchy(self, draw: int, tick: int) -> Hierarchy:
        for target, values in self.targets:
            target.move(values[draw, tick])
        q, v, t = (self.recorded[name][draw, tick] for name in ("q", "v", "t"))
        return self.rows.fill(self.robot.at(q, v), float(t)).copy()


def of_scene(scene: Scene, recorded: Ticks) -> Played:
    """The ticks of a scene."""
    robot = scene.load()
    stack, targets = declare(scene, robot)
    return Played(robot, stack, "velocity", scene.dt, recorded, targets)


def of_figure(figure: Scenario, law: Law, recorded: Ticks) -> Played:
    """The ticks of a scenario of the thesis; where its targets are follows from the time."""
    return Played(figure.arm, law.stack(figure), "acceleration", figure.tick, recorded)


@cache
def motion(name: str) -> Played:
    """The family of this name of the group "motion", built once a process."""
    scene = SCENES[name]
    return of_scene(scene, ticks(scene.robot, name))


@cache
def thesis(name: str) -> Played:
    """The family of this name of the group "thesis", built once a process."""
    figure, law = FIGURES[name]
    return of_figure(scenario(figure), law, ticks("thesis", name))
