r"""Equality constraints and tendons of a MuJoCo model that couple joints, read as mimic joints.

A joint equality with a linear polynomial, :math:`q_1 - q_1^0 = a_0 + a_1 (q_2 - q_2^0)`, makes a joint follow another.
A constraint on a sum of joints cannot be a mimic joint, and is refused; closed chains are read by :mod:`.closures`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import mujoco

from hqp import InvalidInput

from .flags import disabled
from .scene import Scene
from .ties import Tie


def active(mj: mujoco.MjModel) -> list[int]:
    """The equalities that are active."""
    return [] if disabled(mj, "EQUALITY") else [i for i in range(mj.neq) if mj.eq_active0[i]]


def couplings(
    mj: mujoco.MjModel,
    scene: Scene,
    joints: Mapping[int, str],
    what: str,
) -> list[Tie]:
    """The joints of the robot that follow others.

    Parameters
    ----------
    mj : mujoco.MjModel
    scene : Scene
    joints : dict of int to str
        The joints of the robot.
    what : str
        The file, for messages.

    Raises
    ------
    InvalidInput
        If an equality or tendon cannot be a mimic joint; the message names it.
    """
    ties: list[Tie] = []
    for i in active(mj):
        kind, name = mujoco.mjtEq(mj.eq_type[i]), mj.eq(i).name or f"number {i}"
        if kind == mujoco.mjtEq.mjEQ_JOINT:
            tied = (repr(mj.joint(int(j)).name) for j in (mj.eq_obj1id[i], mj.eq_obj2id[i]) if j >= 0)
            ties += _tie(mj, i, joints, f"{what}: joint equality {name!r} of {' and '.join(tied)}")
        elif kind == mujoco.mjtEq.mjEQ_TENDON:
            tendons = [t for t in (int(mj.eq_obj1id[i]), int(mj.eq_obj2id[i])) if t >= 0]
            if any(moves(mj, tendon, scene, joints) for tendon in tendons):
                raise InvalidInput(
                    f"{what}: tendon equality {name!r} ties joints of the robot; only joint ones are read"
                )
    for tendon in range(mj.ntendon):
        if mj.tendon_limited[tendon] and not disabled(mj, "LIMIT") and moves(mj, tendon, scene, joints):
            name = mj.tendon(tendon).name or f"number {tendon}"
            raise InvalidInput(f"{what}: tendon {name!r} has a range over joints of the robot; it must have none")
    return ties


def _tie(mj: mujoco.MjModel, i: int, joints: Mapping[int, str], what: str) -> Iterator[Tie]:
    follower, leader = int(mj.eq_obj1id[i]), int(mj.eq_obj2id[i])
    if follower not in joints and leader not in joints:
        return
    for joint in follower, leader:
        if joint >= 0 and joint not in joints:
            raise InvalidInput(f"{what} ties the robot to joint {mj.joint(joint).name!r}, which is no part of it")
    a0, a1, *higher = (float(a) for a in mj.eq_data[i, :5])
    if any(higher):
        raise InvalidInput(f"{what} has the polynomial {mj.eq_data[i, :5].tolist()}; only linear ones are read")
    start = float(mj.qpos0[mj.jnt_qposadr[follower]])
    if leader < 0:
        yield Tie(joints[follower], None, 0.0, start + a0)
    else:
        yield Tie(joints[follower], joints[leader], a1, start + a0 - a1 * float(mj.qpos0[mj.jnt_qposadr[leader]]))


def moves(mj: mujoco.MjModel, tendon: int, scene: Scene, joints: Collection[int]) -> bool:
    """Whether joints of the robot change the length of a tendon."""
    first = int(mj.tendon_adr[tendon])
    for i in range(first, first + int(mj.tendon_num[tendon])):
        kind, own = mujoco.mjtWrap(mj.wrap_type[i]), int(mj.wrap_objid[i])
        if kind == mujoco.mjtWrap.mjWRAP_JOINT and own in joints:
            return True
        if kind == mujoco.mjtWrap.mjWRAP_SITE and int(mj.site_bodyid[own]) in scene.bodies:
            return True
    return False
