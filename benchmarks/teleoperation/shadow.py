"""By how much the levels below have moved the first task of this library."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hqp.arrays import Array

from ..ticks.ours import Ours
from ..ticks.stream import Stream
from .loop import Run
from .setups import Own


def moved(stream: Stream, run: Run, setup: Own) -> Array | None:
    """How far the hand is from where the first task alone would have it, tick by tick, shape (ticks, 3) [m].

    At every state of the run the stack is asked again without the levels below. What it does differently adds up to a
    displacement d, and what it would do from there, with its target displaced by d too, takes that back:

        d <- d + dt J (v - v_alone(target + d))

    so that a push which the task's own pull balances is counted once. None where the first level is no position alone.
    """
    (goal, *others), *_ = stream.scene.levels
    if others or goal.what != "position":
        return None
    alone = Ours(replace(stream, scene=replace(stream.scene, levels=stream.scene.levels[:1])), **setup.options)
    target, aims = next((target, aims) for target, aims in alone.targets if np.shape(aims[0]) == (3,))
    d, all_d = np.zeros(3), np.zeros((len(stream), 3))
    for k in range(len(stream)):
        q, v = run.q[k], run.v[k - 1] if k else run.v[0]
        target.move(aims[k] + d)
        step = alone.controller(q, v)
        J = stream.robot.at(q, v).frame(goal.frame).linear
        d = d + stream.scene.dt * J @ (run.v[k] - alone.velocity(step))
        all_d[k] = d
    return all_d
