"""The motors of an MJCF: what they add to joints of the robot, and limits of theirs that are not read.

The rotor of an actuator on a joint, with armature A, damping d and gear g, adds :math:`g^2 A` to the inertia of the
joint and :math:`g^2 d` to its damping.
"""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from ...base.checks import Array
from .couplings import moves
from .mujoco_numbers import FREE, HINGE, SLIDE
from .scene import Scene

#: Transmissions that act on one joint.
ON_JOINTS = int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)


def rotors(mj: mujoco.MjModel) -> tuple[Array, Array]:
    """What the actuators add to the armature and to the damping of MuJoCo's velocities, each (nv,)."""
    armature, damping = np.zeros((2, mj.nv))
    for i in filter(lambda i: _has_rotor(mj, i), range(mj.nu)):
        dof, square = int(mj.jnt_dofadr[mj.actuator_trnid[i, 0]]), float(mj.actuator_gear[i, 0]) ** 2
        armature[dof] += square * float(mj.actuator_armature[i])
        damping[dof] += square * float(mj.actuator_damping[i])
    return armature, damping


def other_rotors(mj: mujoco.MjModel) -> list[str]:
    """The actuators with an armature or a damping that is none of one joint, or not linear."""
    return [
        mj.actuator(i).name or f"number {i}"
        for i in range(mj.nu)
        if np.any(mj.actuator_dampingpoly[i])
        or ((mj.actuator_armature[i] or mj.actuator_damping[i]) and not _has_rotor(mj, i))
    ]


def _has_rotor(mj: mujoco.MjModel, i: int) -> bool:
    """Whether an actuator turns with one joint, a hinge or a slide."""
    return mj.actuator_trntype[i] in ON_JOINTS and mj.jnt_type[mj.actuator_trnid[i, 0]] in (HINGE, SLIDE)


def motor_limits(mj: mujoco.MjModel, joints: Mapping[int, str]) -> list[str]:
    """The joints (number, name) with an actuator of limited force that have no limit of their own.

    The force of an actuator is limited by its range of forces, and that of a motor, whose force is its control times a
    constant, by its range of controls. ``actuatorfrcrange`` of a joint is read, and stands for both.
    """
    found = [
        joints[int(mj.actuator_trnid[i, 0])]
        for i in range(mj.nu)
        if mj.actuator_trntype[i] in ON_JOINTS and int(mj.actuator_trnid[i, 0]) in joints and _is_limited(mj, i)
    ]
    return list(dict.fromkeys(found))


def without_actuators(mj: mujoco.MjModel, joints: Mapping[int, str]) -> list[str]:
    """The joints (number, name) on which no actuator acts, by itself or by a tendon, if actuators act on others."""
    driven = set[int]()
    for i in range(mj.nu):
        target = int(mj.actuator_trnid[i, 0])
        if mj.actuator_trntype[i] in ON_JOINTS:
            driven.add(target)
        elif mj.actuator_trntype[i] == int(mujoco.mjtTrn.mjTRN_TENDON):
            first = int(mj.tendon_adr[target])
            wraps = range(first, first + int(mj.tendon_num[target]))
            driven |= {int(mj.wrap_objid[k]) for k in wraps if mj.wrap_type[k] == int(mujoco.mjtWrap.mjWRAP_JOINT)}
    own = [j for j in joints if mj.jnt_type[j] != FREE]
    return [joints[j] for j in own if j not in driven] if driven.intersection(own) else []


def limits_elsewhere(mj: mujoco.MjModel, scene: Scene, joints: Mapping[int, str]) -> list[str]:
    """The actuators of limited force that are on no joint, and the tendons that limit those on them, of the robot."""
    found = [
        f"actuator {mj.actuator(i).name or f'number {i}'}"
        for i in range(mj.nu)
        if mj.actuator_trntype[i] not in ON_JOINTS and _force_is_limited(mj, i) and _acts_on(mj, i, scene, joints)
    ]
    tendons = [t for t in range(mj.ntendon) if mj.tendon_actfrclimited[t] and moves(mj, t, scene, joints)]
    return found + [f"tendon {mj.tendon(t).name or f'number {t}'}" for t in tendons]


def _acts_on(mj: mujoco.MjModel, i: int, scene: Scene, joints: Mapping[int, str]) -> bool:
    """Whether an actuator that is on no joint acts on the robot: by a tendon, or at a site or body."""
    what, own = int(mj.actuator_trntype[i]), int(mj.actuator_trnid[i, 0])
    if what == int(mujoco.mjtTrn.mjTRN_TENDON):
        return moves(mj, own, scene, joints)
    body = own if what == int(mujoco.mjtTrn.mjTRN_BODY) else int(mj.site_bodyid[own])
    return body in scene.bodies


def _is_limited(mj: mujoco.MjModel, i: int) -> bool:
    return not mj.jnt_actfrclimited[int(mj.actuator_trnid[i, 0])] and _force_is_limited(mj, i)


def _force_is_limited(mj: mujoco.MjModel, i: int) -> bool:
    fixed = mj.actuator_gaintype[i] == int(mujoco.mjtGain.mjGAIN_FIXED)
    motor = fixed and mj.actuator_biastype[i] == int(mujoco.mjtBias.mjBIAS_NONE)
    return bool(mj.actuator_forcelimited[i] or (motor and mj.actuator_ctrllimited[i]))
