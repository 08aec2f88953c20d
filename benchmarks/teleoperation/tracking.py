"""The distance of the frames that are led from their targets, and the least distance that is possible."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hqp.arrays import Array
from tasks import solve_ik
from tasks.base.rotations import log

from ..ticks.stack import declare
from ..ticks.stream import Stream
from .loop import Run

if TYPE_CHECKING:
    from tasks.robots.frame import Frame

#: Of how many ticks one is asked how near the targets could be; in between it is interpolated.
EVERY = 20


@dataclass(frozen=True, eq=False)
class Tracking:
    """How a run kept to its targets, tick by tick.

    Attributes
    ----------
    far, excess : array, shape (ticks,)
        Distance of the frames that are led from their targets, root mean square of all, and what of it no configuration
        forces [m].
    turned : array, shape (ticks,)
        The same of angles, of frames whose orientation is asked for; empty where none is [rad].
    strayed : array, shape (ticks,)
        How far the frames that are to stay where they are have gone, the farthest; empty where none is [m].
    """

    far: Array
    excess: Array
    turned: Array
    strayed: Array


def track(stream: Stream, runs: Sequence[Run], forced: Array) -> dict[str, Tracking]:
    """The same for all runs of a stream.

    Parameters
    ----------
    forced : array, shape (ticks,)
        What inverse kinematics finds; it is less where one of the runs came nearer.
    """
    measured = {run.name: errors(stream, run.q) for run in runs}
    forced = np.min([forced, *(far for far, _ in measured.values())], axis=0)
    return {
        run.name: Tracking(far, far - forced, turned, strayed(stream, run.q))
        for run, (far, turned) in zip(runs, measured.values(), strict=True)
    }


def errors(stream: Stream, q: Array) -> tuple[Array, Array]:
    """Distances [m] and angles [rad] between frames that are led and their targets, at the beginning of each tick."""
    scene, far, turned = stream.scene, [], []
    for frame in scene.led:
        places, p, R = _places(stream, frame, q), stream.positions[frame], stream.rotations[frame]
        far.append([np.linalg.norm(target - place.position) for target, place in zip(p, places, strict=True)])
        if scene.cost(frame, "orientation", "pose"):
            turned.append([np.linalg.norm(log(to @ at.rotation.T)) for to, at in zip(R, places, strict=True)])
    return _together(far), _together(turned)


def strayed(stream: Stream, q: Array) -> Array:
    """How far the frames that stand have gone, the farthest, at the beginning of each tick [m]."""
    far = [
        [np.linalg.norm(place.position - stream.positions[frame][0]) for place in _places(stream, frame, q)]
        for frame in stream.scene.standing
    ]
    return np.max(far, axis=0) if far else np.zeros(0)


def inevitable(stream: Stream, ticks: Iterable[int] | None = None) -> Array:
    """How far the frames that are led are at least from their targets, wherever the joints are in their ranges [m].

    By inverse kinematics of the levels down to theirs.

    Parameters
    ----------
    ticks : ints, optional
        Which ones are asked for: by default all, shape (ticks,), most of them interpolated.
    """
    robot, last = stream.robot, len(stream) - 1
    asked = np.unique([*range(0, last, EVERY), last]) if ticks is None else np.array(list(ticks))
    scene = stream.scene
    depth = next(k for k, level in enumerate(scene.levels, start=1) if any(goal.frame in scene.led for goal in level))
    stack, targets = declare(replace(scene, levels=scene.levels[:depth]), robot)
    q, least = robot.home, []
    for k in asked:
        for name, target in targets.positions.items():
            target.move(stream.positions[name][k])
        q = solve_ik(robot, stack, q).q
        state = robot.at(q, np.zeros(robot.nv))
        far = [np.linalg.norm(stream.positions[frame][k] - state.frame(frame).position) for frame in scene.led]
        least.append(float(_together([[x] for x in far])[0]))
    return np.array(least) if ticks is not None else np.interp(np.arange(last + 1), asked, least)


def _places(stream: Stream, frame: str, q: Array) -> list[Frame]:
    still = np.zeros(stream.robot.nv)
    return [stream.robot.at(row, still).frame(frame) for row in q[: len(stream)]]


def _together(values: Sequence[Sequence[float]]) -> Array:
    """Root mean square over frames, shape (ticks,); empty of none."""
    return np.sqrt(np.mean(np.square(values), axis=0)) if values else np.zeros(0)
