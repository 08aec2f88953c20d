"""Configurations and velocities of a robot on Pinocchio, in the coordinates of a MuJoCo model, joint by joint."""

from __future__ import annotations

from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from hqp import InvalidInput
from hqp.errors import brief

from ..base.checks import Array, suggestion
from ..robots.robot import Robot, on_pinocchio

if TYPE_CHECKING:
    import mujoco

#: (x, y, z, w) of Pinocchio as (w, x, y, z) of MuJoCo.
QUATERNION = [3, 0, 1, 2]


class MujocoJoints:
    """Which joint of a MuJoCo model each joint of a robot is: by name, and the floating base by being the free joint.

    Parameters
    ----------
    robot : PinocchioRobot
    model : mujoco.MjModel
        It may have more joints than the robot: they stay where they are.
    what : str
        Who needs it, for messages.

    Raises
    ------
    InvalidInput
        If the robot is not on Pinocchio, or has a joint that the model has not.
    """

    def __init__(self, robot: Robot, model: mujoco.MjModel, what: str) -> None:
        import mujoco

        if not on_pinocchio(robot):
            raise InvalidInput(f"{what}: robot = {brief(robot)}; joints are matched on a PinocchioRobot")
        self._n = int(model.nv)
        pin_model: Any = robot.model
        theirs = {model.joint(i).name: i for i in range(model.njnt)}
        free = [i for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE]
        #: Of every joint: its kind, and where it begins in q, v, qpos and qvel.
        self._joints: list[tuple[str, int, int, int, int]] = []
        for index in range(1, pin_model.njoints):
            joint, name = pin_model.joints[index], pin_model.names[index]
            kind = _kind(joint.shortname(), joint.nq, joint.nv)
            other = theirs.get(name, free[0] if kind == "free" and len(free) == 1 else None)
            if other is None:
                raise InvalidInput(f"{what}: joint {name!r} is not in mink's model{suggestion(name, theirs)}")
            if KINDS[int(model.jnt_type[other])] != ("line" if kind == "circle" else kind):
                raise InvalidInput(f"{what}: joint {name!r} moves otherwise in mink's model")
            self._joints.append(
                (kind, joint.idx_q, joint.idx_v, int(model.jnt_qposadr[other]), int(model.jnt_dofadr[other]))
            )

    def qpos(self, q: Array, rest: Array) -> Array:
        """MuJoCo's configuration for q, shape (model.nq,); joints that the robot does not have are as in `rest`."""
        found = np.array(rest, dtype=float)
        for kind, at, _, there, _ in self._joints:
            if kind == "line":
                found[there] = q[at]
            elif kind == "circle":
                angle = np.arctan2(q[at + 1], q[at])
                # MuJoCo counts turns, a circle does not: the nearest to where it was.
                found[there] = angle + 2.0 * np.pi * np.round((found[there] - angle) / (2.0 * np.pi))
            else:
                place = 3 if kind == "free" else 0
                found[there : there + place] = q[at : at + place]
                turn = slice(at + place, at + place + 4)
                found[there + place : there + place + 4] = q[turn][QUATERNION]
        return found

    def velocities(self, q: Array) -> Array:
        """T of qvel = T v, shape (model.nv, nv): a free joint moves along the world there, and along itself here."""
        widths = {"line": 1, "circle": 1, "ball": 3, "free": 6}
        T = np.zeros((self._n, sum(widths[kind] for kind, *_ in self._joints)))
        for kind, at, column, _, row in self._joints:
            width = widths[kind]
            T[row : row + width, column : column + width] = np.eye(width)
            if kind == "free":
                T[row : row + 3, column : column + 3] = _rotation(q[at + 3 : at + 7])
        return T


def check_same_joints(own: Any, model: Any, what: str) -> None:
    """Refuse an object whose MuJoCo model differs from another model in the names or order of its joints.

    Raises
    ------
    InvalidInput
        The message names the first difference.
    """
    import mujoco

    if own is model or not isinstance(own, mujoco.MjModel):
        return
    joints = ([(one.joint(i).name, int(one.jnt_type[i])) for i in range(one.njnt)] for one in (own, model))
    for number, (made, measured) in enumerate(zip_longest(*joints)):
        if made != measured:
            raise InvalidInput(
                f"{what}: joint {number} of the model that it was made of is {made and made[0]!r}, of the configuration"
                f" {measured and measured[0]!r}; make it of configuration.model"
            )


#: What MuJoCo calls 0 to 3: free, ball, slide, hinge.
KINDS = ("free", "ball", "line", "line")


def _kind(shortname: str, nq: int, nv: int) -> str:
    """How a joint of Pinocchio moves, as far as MuJoCo has it in one joint."""
    if shortname == "JointModelFreeFlyer":
        return "free"
    if shortname == "JointModelSpherical":
        return "ball"
    return {(1, 1): "line", (2, 1): "circle"}.get((nq, nv), shortname)


def _rotation(quaternion: Array) -> Array:
    import pinocchio as pin

    rotation: Array = pin.Quaternion(np.array(quaternion)).toRotationMatrix()
    return rotation
