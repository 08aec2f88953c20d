"""Displacement of the first task of this library by the levels below."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hqp import Hierarchy, Level, Solver
from hqp.arrays import Array

from ..ticks.ours import Ours
from ..ticks.stream import Stream
from .loop import Run
from .setups import Own

#: How long the first task is let alone, in time constants 1 / K.
ALONE = 5.0


def moved(stream: Stream, run: Run, setup: Own) -> float | None:
    """By how much, at most, the hand is farther from its target than if the levels below had said nothing [m].

    The run is cut into pieces of 5 / K. From the beginning of each the first task goes on alone, in a loop of its own;
    at the end, where its own pull has balanced what pushes it, the distances from the target are compared. None where
    the first level is no position alone.
    """
    if not _is_position(stream):
        return None
    alone = _alone(stream, setup)
    return _farther(stream, run, lambda k, q, v: _asked(alone, k, q, v))


def pushed(stream: Stream, run: Run, setup: Own) -> float | None:
    """The same against a hand that the levels below cannot push, while the joints follow them [m].

    A hand that goes on alone takes other joint positions than one with levels below it, from which its speed limits may
    let it come back sooner or later: that is redundancy, not a level below that moves one above. Here each tick asks
    for the limits > the velocities of the first task's rows as it alone wants them > the x of all levels.
    """
    if not _is_position(stream):
        return None
    alone, whole, solver = _alone(stream, setup), Ours(stream, **setup.options), Solver()

    def tick(k: int, q: Array, v: Array) -> Array:
        own = _asked(alone, k, q, v)
        whole.stand(k, q, v)
        step = whole.tick(k)
        if not step.ok:
            return own
        limits, task = step.solution.hierarchy.levels[:2]
        rows = np.array(step.solution.hierarchy.matrix(1)) * task.weights[:, None]
        bounds = np.array(step.solution.hierarchy.matrix(0)), limits.lower.copy(), limits.upper.copy()
        x = whole.velocity(step)
        kept, rest = Level(rows, rows @ own, rows @ own), Level(np.eye(len(x)), x, x)
        return solver.solve(Hierarchy([Level(*bounds), kept, rest])).x

    return _farther(stream, run, tick)


def _is_position(stream: Stream) -> bool:
    """Whether the first level is a position alone."""
    (goal, *others), *_ = stream.scene.levels
    return not others and goal.what == "position"


def _alone(stream: Stream, setup: Own) -> Ours:
    """The first task, without levels below."""
    return Ours(replace(stream, scene=replace(stream.scene, levels=stream.scene.levels[:1])), **setup.options)


def _asked(driver: Ours, k: int, q: Array, v: Array) -> Array:
    driver.stand(k, q, v)
    return driver.velocity(driver.tick(k))


def _farther(stream: Stream, run: Run, tick: Callable[[int, Array, Array], Array]) -> float:
    """By how much, at most, the hand of a run is farther off than that of a loop that follows `tick`."""
    scene, robot = stream.scene, stream.robot
    frame = scene.levels[0][0].frame
    targets = stream.positions[frame]
    piece = max(1, round(ALONE / (scene.gain * scene.dt)))
    worst = 0.0
    for first in range(0, len(stream) - piece, piece):
        q, v = run.q[first], run.v[first - 1] if first else np.zeros(robot.nv)
        for k in range(first, first + piece):
            v = tick(k, q, v)
            q = robot.integrate(q, scene.dt * v)
        far = [
            np.linalg.norm(targets[first + piece] - robot.at(end, v).frame(frame).position)
            for end in (run.q[first + piece], q)
        ]
        worst = max(worst, float(far[0] - far[1]))
    return worst
