r"""Where the state of a Pinocchio robot is in that of a MuJoCo model.

=================  ============================  ==================================
joint              Pinocchio                     MuJoCo
=================  ============================  ==================================
one axis           angle or length               the same
without end        cosine and sine of the angle  the angle
ball               quaternion (x, y, z, w)       (w, x, y, z)
floating base      position, quaternion;         position, quaternion; the linear
                   velocities along its axes     velocity along those of the world
=================  ============================  ==================================
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.checks import Array
from .mujoco_model import ball, free, joints, unbounded

#: The entries of MuJoCo's quaternion (w, x, y, z) in the order of Pinocchio's.
QUATERNION = 1, 2, 3, 0


class StatePlaces:
    """The map between both, for one robot.

    Parameters
    ----------
    robot : PinocchioRobot
    model : mujoco.MjModel
        Made of it.

    Attributes
    ----------
    dofs : array of int
        Places of the joints, without a floating base, among MuJoCo's velocities.
    """

    def __init__(self, robot: Any, model: Any) -> None:
        same, there, dofs, angles, circles = (list[int]() for _ in range(5))
        self._floats = False
        for joint, name in joints(robot.model):
            own = model.joint(name)
            q, at = int(joint.idx_q), int(own.qposadr[0])
            if free(joint):
                self._floats = True
                same += range(q, q + 7)
                there += [*range(at, at + 3), *(at + 3 + k for k in QUATERNION)]
                continue
            dofs += range(own.dofadr[0], own.dofadr[0] + joint.nv)
            if unbounded(joint):
                circles.append(q)
                angles.append(at)
                continue
            same += range(q, q + joint.nq)
            there += [at + k for k in QUATERNION] if ball(joint) else [at]
        self._nq, self._nv = robot.nq, robot.nv
        self.dofs = np.array(dofs, dtype=np.intp)
        self._same, self._there = np.array(same, dtype=np.intp), np.array(there, dtype=np.intp)
        self._circles, self._angles = np.array(circles, dtype=np.intp), np.array(angles, dtype=np.intp)

    def put(self, data: Any, q: Array, v: Array) -> None:
        """Set the state of MuJoCo's data."""
        data.qpos[self._there] = q[self._same]
        data.qpos[self._angles] = np.arctan2(q[self._circles + 1], q[self._circles])
        if self._floats:
            data.qvel[:3], data.qvel[3:6] = _rotation(q) @ v[:3], v[3:6]
        data.qvel[self.dofs] = v[self._nv - len(self.dofs) :]

    def take(self, data: Any) -> tuple[Array, Array]:
        """The state of MuJoCo's data, as q and v of the robot."""
        q, v = np.zeros(self._nq), np.zeros(self._nv)
        q[self._same] = data.qpos[self._there]
        q[self._circles], q[self._circles + 1] = np.cos(data.qpos[self._angles]), np.sin(data.qpos[self._angles])
        if self._floats:
            v[:3], v[3:6] = data.qvel[:3] @ _rotation(q), data.qvel[3:6]
        v[self._nv - len(self.dofs) :] = data.qvel[self.dofs]
        return q, v


def _rotation(q: Array) -> Array:
    """The rotation matrix of a floating base, from the quaternion (x, y, z, w) in q."""
    x, y, z, w = q[3:7] / np.linalg.norm(q[3:7])
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
