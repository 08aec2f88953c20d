"""Closed chains in physics: the loops that a plant closes, and how MuJoCo closes them.

A pin becomes a ``connect`` constraint of MuJoCo between two sites, and a loop that holds the orientation a ``weld``.
They are springs, as stiff as MuJoCo allows, critically damped.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from hqp import InvalidInput
from hqp.checks import listed, of_type

from ..base.checks import Array
from ..contacts.loop import Loop
from ..robots.robot import Robot, check_frame
from .mujoco_model import carrier, quaternion

#: Time constant of their springs, in steps of the physics: MuJoCo takes none that is shorter.
STEPS = 2.0
#: Impedance, the most that MuJoCo takes: of the motion without the loop, 1 less this share is left.
IMPEDANCE = 0.9999


def loops_of(robot: Robot, loops: Iterable[Loop] | None, what: str) -> tuple[Loop, ...]:
    """The loops that the plant `what` closes: those given, or else those in the file of the robot.

    Raises
    ------
    InvalidInput
        If the robot lacks a frame of one, or one does not say which orientation it holds.
    """
    if loops is None:
        return Loop.of(robot)
    given = tuple(of_type(loop, Loop, "a loop") for loop in listed(loops, "loops", "Loop"))
    for loop in given:
        for frame in loop.a, loop.b:
            check_frame(robot, frame, f"{loop.full_name()}: frame")
        if not loop.turns and loop.rotation is None:
            raise InvalidInput(
                f"{what}: {loop.full_name()}: holds axes that are found at the first tick; give rotation="
            )
    return given


def ends(robot: Any, loop: Loop) -> list[tuple[int, Any]]:
    """Of both frames of a loop: the joint that moves it, and the place on it that coincides with the other's."""
    import pinocchio as pin

    found = []
    for name, at, rotation in (loop.a, loop.at, None), (loop.b, loop.at_b, loop.rotation):
        frame = robot.model.frames[robot.frame_index(name)]
        held = pin.SE3(np.eye(3) if rotation is None else rotation, at)
        found.append((int(frame.parentJoint), frame.placement * held))
    return found


def close(specification: Any, loops: Sequence[Loop], robot: Any, step: float, mujoco: Any) -> None:
    """Add these loops to a MuJoCo specification.

    Parameters
    ----------
    specification : mujoco.MjSpec
    loops : sequence of Loop
    robot : PinocchioRobot
    step : float
        Of the physics [s].
    mujoco : module

    Raises
    ------
    InvalidInput
        If a frame is on a link without mass that moves.
    """
    for loop in loops:
        names = [f"{loop.name}: {end}" for end in "ab"]
        for name, frame, (_, place) in zip(names, (loop.a, loop.b), ends(robot, loop), strict=True):
            body = carrier(specification, robot, frame, loop.full_name())
            body.add_site(name=name, pos=place.translation, quat=quaternion(place.rotation))
        kind = mujoco.mjtEq.mjEQ_CONNECT if loop.turns else mujoco.mjtEq.mjEQ_WELD
        added = specification.add_equality(name=loop.name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE)
        added.name1, added.name2 = names
        added.solref, added.solimp[:2] = [STEPS * step, 1.0], IMPEDANCE
    if loops:
        specification.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST


def loop_forces(model: Any, data: Any, loops: Sequence[Loop], mujoco: Any) -> dict[str, Array]:
    """Name of a loop -> force on its first frame in the last step, shape (3,) [N], along the axes of the world.

    With the moment about its point if it does not turn, shape (6,), [N] and [N m].
    """
    found = {}
    for loop in loops:
        number = model.equality(loop.name).id
        own = (data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)) & (data.efc_id == number)
        f = data.efc_force[own].copy()
        if not loop.turns:
            f[3:] = _turning(model, data, loop, mujoco).T @ f[3:]
        found[loop.name] = f
    return found


def _turning(model: Any, data: Any, loop: Loop, mujoco: Any) -> Array:
    r"""How the error of orientation of a weld changes as its first frame turns in the world, shape (3, 3).

    MuJoCo measures it by the vector part of :math:`p^{-1} q`, with q and p the quaternions of both sites:
    its rate under an angular velocity w is half of that of :math:`p^{-1} w\, q`.
    """
    q, p, half, whole = np.zeros((4, 4))
    for own, end in (q, "a"), (p, "b"):
        mujoco.mju_mat2Quat(own, data.site(f"{loop.name}: {end}").xmat)
    p[1:] *= -1.0
    rates = np.zeros((3, 3))
    for k in range(3):
        mujoco.mju_mulQuat(half, p, np.eye(4)[1 + k])
        mujoco.mju_mulQuat(whole, half, q)
        rates[:, k] = 0.5 * whole[1:]
    return rates
