"""The distance of a frame from its target, and the least distance that is possible."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hqp.arrays import Array
from tasks import PositionTask, solve_ik
from tasks.base.rotations import log

from ..ticks.stream import Stream

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: Of how many ticks one is asked how near the target could be; in between it is interpolated.
EVERY = 20


def errors(stream: Stream, frame: str, q: Array) -> tuple[Array, Array]:
    """Distances [m] and angles [rad] between a frame and its target, at the beginning of each tick, shape (ticks,)."""
    robot, still = stream.robot, np.zeros(stream.robot.nv)
    places = [robot.at(row, still).frame(frame) for row in q[: len(stream)]]
    p, R = stream.positions[frame], stream.rotations[frame]
    far = np.linalg.norm([target - place.position for target, place in zip(p, places, strict=True)], axis=1)
    turned = [np.linalg.norm(log(target @ place.rotation.T)) for target, place in zip(R, places, strict=True)]
    return far, np.array(turned)


def inevitable(stream: Stream, frame: str) -> Array:
    """How far the frame is at least from its target, wherever the joints are in their ranges [m], shape (ticks,).

    By inverse kinematics of the position alone.
    """
    ticks = len(stream)
    sample = np.unique([*range(0, ticks, EVERY), ticks - 1])
    q, least = stream.robot.home, []
    for target in stream.positions[frame][sample]:
        q, far = _nearest(stream.robot, frame, target, q)
        least.append(far)
    return np.interp(np.arange(ticks), sample, least)


def _nearest(robot: PinocchioRobot, frame: str, target: Array, q: Array) -> tuple[Array, float]:
    """A configuration that brings the frame as near as was found, and how near that is [m]."""
    q = solve_ik(robot, PositionTask(target, frame=frame, gain=1.0), q).q
    return q, float(np.linalg.norm(target - robot.at(q, np.zeros(robot.nv)).frame(frame).position))
