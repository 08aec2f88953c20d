"""A robot as a stick figure: lines from joint to joint, ready to be drawn."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import listed, of_type

from ..base.checks import Array, finite
from .robot import Robot, as_robot, on_pinocchio, points

if TYPE_CHECKING:
    from .pinocchio import PinocchioRobot

#: Segments shorter than this [m], between joints at the same place, are not drawn.
SHORT = 1e-9


def skeleton(robot: Robot, q: ArrayLike, *, frames: Iterable[str] = ()) -> Array:
    """The links as segments, from the origin of each joint to that of its parent, without those of length 0.

    Parameters
    ----------
    robot : Robot
        A planar arm, a Pinocchio robot, or one with `points`.
    q : array, shape (nq,)
        A configuration.
    frames : names of frames
        For a Pinocchio robot: ends to draw beyond the last joints, such as hands and feet. The tip is always drawn.

    Returns
    -------
    array, shape (segments, 2, 3)
        Start and end of each segment [m], in the world; z is 0 for a planar arm.

    Raises
    ------
    InvalidInput
        If q does not fit, there is no such frame, or the robot has neither points nor joints to draw.

    Examples
    --------
    >>> from tasks import PlanarArm, skeleton
    >>> skeleton(PlanarArm([0.5, 0.5]), [0.0, 0.0]).shape
    (2, 2, 3)
    """
    as_robot(robot)
    names = [of_type(name, str, "frames: name") for name in listed(frames, "frames", "names")]
    q = finite(q, "q")
    if q.shape != (robot.nq,):
        raise InvalidInput(f"q has shape {q.shape}; the robot takes ({robot.nq},)")
    if on_pinocchio(robot):
        segments = _spatial(robot, q, names)
    else:
        line = _line(robot, q)
        segments = np.stack([line[:-1], line[1:]], axis=1)
    return np.asarray(segments[np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) > SHORT])


def _line(robot: Robot, q: Array) -> Array:
    """The points from the base to the tip, shape (k, 3)."""
    own = points(robot)
    if own is None or not callable(own):
        raise InvalidInput(f"{robot!r} tells no points(q), and is no robot of Pinocchio; it has no skeleton")
    line = finite(own(q), f"points(q) of {robot!r}")
    if line.ndim != 2 or len(line) < 2 or line.shape[1] not in (2, 3):
        raise InvalidInput(f"points(q) of {robot!r} has shape {line.shape}; it must be (k, 2) or (k, 3), k at least 2")
    return np.pad(line, ((0, 0), (0, 3 - line.shape[1])))


def _spatial(robot: PinocchioRobot, q: Array, frames: list[str]) -> Array:
    import pinocchio as pin

    model, data = robot.model, robot.model.createData()  # separate: the robot's own data belongs to the present state
    pin.framesForwardKinematics(model, data, q)
    # A free base is not attached: no line is drawn to it from the origin of the world.
    joints = range(2 if robot.base else 1, model.njoints)
    segments = [(data.oMi[int(model.parents[i])].translation, data.oMi[i].translation) for i in joints]
    for name in dict.fromkeys([*([] if robot.tip is None else [robot.tip]), *frames]):
        index = robot.frame_index(name)
        frame = model.frames[index]
        segments.append((data.oMi[int(frame.parentJoint)].translation, data.oMf[index].translation))
    return np.array(segments).reshape(-1, 2, 3)
