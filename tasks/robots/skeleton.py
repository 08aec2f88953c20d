"""A robot as a stick figure: lines from joint to joint, ready to be drawn."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import listed, of_type

from .._checks import Array, finite
from .robot import Robot, as_robot, on_pinocchio

if TYPE_CHECKING:
    from .pinocchio import PinocchioRobot

#: Segments shorter than this [m] are not drawn: joints at one place.
SHORT = 1e-9


def skeleton(robot: Robot, q: ArrayLike, *, frames: Iterable[str] = ()) -> Array:
    """Where the links are: one segment from the origin of each joint to that of its parent, without those of length 0.

    Parameters
    ----------
    robot : Robot
        A planar arm, or a robot of Pinocchio.
    q : array, shape (nq,)
        A configuration.
    frames : names of frames
        Of a robot of Pinocchio: ends to be drawn beyond the last joints, such as hands and feet. The tip is always.

    Returns
    -------
    array, shape (segments, 2, 3)
        Start and end of each segment [m], in the world; z is 0 for a planar arm.

    Raises
    ------
    InvalidInput
        If q does not fit, there is no such frame, or the robot tells neither points nor joints.
    """
    as_robot(robot)
    names = [of_type(name, str, "frames: name") for name in listed(frames, "frames", "names")]
    q = finite(q, "q")
    if q.shape != (robot.nq,):
        raise InvalidInput(f"q has shape {q.shape}; the robot takes ({robot.nq},)")
    if on_pinocchio(robot):
        segments = _spatial(robot, q, names)  # type: ignore[arg-type]
    elif hasattr(robot, "points"):
        points = np.pad(robot.points(q), ((0, 0), (0, 1)))
        segments = np.stack([points[:-1], points[1:]], axis=1)
    else:
        raise InvalidInput(f"{robot!r} tells neither points(q) nor a model; it has no skeleton")
    return np.asarray(segments[np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) > SHORT])


def _spatial(robot: PinocchioRobot, q: Array, frames: list[str]) -> Array:
    import pinocchio as pin

    model, data = robot.model, robot.model.createData()  # its own: the robot's belongs to the state of a tick
    pin.framesForwardKinematics(model, data, q)
    # A base that moves freely hangs on nothing: no line leads to it from the origin of the world.
    joints = range(2 if robot.base else 1, model.njoints)
    segments = [(data.oMi[int(model.parents[i])].translation, data.oMi[i].translation) for i in joints]
    for name in dict.fromkeys([*([] if robot.tip is None else [robot.tip]), *frames]):
        index = robot.frame_index(name)
        frame = model.frames[index]
        segments.append((data.oMi[int(frame.parentJoint)].translation, data.oMf[index].translation))
    return np.array(segments).reshape(-1, 2, 3)
