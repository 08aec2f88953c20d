"""Displacement of the first task of this library by the levels below."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

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
    scene = stream.scene
    (goal, *others), *_ = scene.levels
    if others or goal.what != "position":
        return None
    robot, targets = stream.robot, stream.positions[goal.frame]
    alone = Ours(replace(stream, scene=replace(scene, levels=scene.levels[:1])), **setup.options)
    piece = max(1, round(ALONE / (scene.gain * scene.dt)))
    worst = 0.0
    for first in range(0, len(stream) - piece, piece):
        q, v = run.q[first], run.v[first - 1] if first else np.zeros(robot.nv)
        for k in range(first, first + piece):
            alone.stand(k, q, v)
            v = alone.velocity(alone.tick(k))
            q = robot.integrate(q, scene.dt * v)
        far = [
            np.linalg.norm(targets[first + piece] - robot.at(end, v).frame(goal.frame).position)
            for end in (run.q[first + piece], q)
        ]
        worst = max(worst, float(far[0] - far[1]))
    return worst
