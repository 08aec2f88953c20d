"""Conversions from MuJoCo to Pinocchio: poses, quaternions and joints; and random joint positions."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from ...base.checks import Array

FREE, BALL, SLIDE, HINGE = range(4)
#: Axes for which Pinocchio has joints of their own, which are faster.
ALIGNED = {(1.0, 0.0, 0.0): "X", (0.0, 1.0, 0.0): "Y", (0.0, 0.0, 1.0): "Z"}


def dofs(mj: mujoco.MjModel, j: int) -> list[int]:
    """The places of the velocities of a joint among all of MuJoCo."""
    first = int(mj.jnt_dofadr[j])
    return list(range(first, first + {FREE: 6, BALL: 3}.get(int(mj.jnt_type[j]), 1)))


def pose(position: Array, quaternion: Array) -> pin.SE3:
    """A pose of MuJoCo, with its quaternion w, x, y, z."""
    rotation = pin.Quaternion(xyzw(quaternion)).toRotationMatrix()
    return pin.SE3(rotation, np.array(position))


def xyzw(quaternion: Array) -> Array:
    """A quaternion of MuJoCo, w, x, y, z, as Pinocchio writes it, of norm 1."""
    w, x, y, z = quaternion
    own = np.array([x, y, z, w])
    return np.asarray(own / np.linalg.norm(own))


def yaw_of(rotation: Array) -> float:
    """The yaw angle of a body, about the vertical [rad]."""
    return float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def single_joint(slides: bool, axis: Array) -> Any:
    """Pinocchio's joint that turns about this axis, or slides along it."""
    letter = ALIGNED.get((float(axis[0]), float(axis[1]), float(axis[2])))
    if letter is not None:
        return getattr(pin, f"JointModel{'P' if slides else 'R'}{letter}")()
    return (pin.JointModelPrismaticUnaligned if slides else pin.JointModelRevoluteUnaligned)(axis)


def randomise(mj: mujoco.MjModel, j: int, qpos: Array, rng: np.random.Generator) -> None:
    """Put a joint somewhere in its range."""
    address, what = int(mj.jnt_qposadr[j]), int(mj.jnt_type[j])
    if what == FREE:
        qpos[address : address + 7] = [*rng.uniform(-1.0, 1.0, 3), *rng.standard_normal(4)]
    elif what == BALL:
        qpos[address : address + 4] = rng.standard_normal(4)
    else:
        low, high = mj.jnt_range[j] if mj.jnt_limited[j] else (-np.inf, np.inf)
        qpos[address] = rng.uniform(max(low, min(high, np.pi) - 2.0 * np.pi), min(high, max(low, -np.pi) + 2.0 * np.pi))
