"""The motors of an MJCF: what they add to joints of the robot, what they have at most, and limits that are not read.

The rotor of an actuator on a joint, with armature A, damping d and gear g, adds :math:`g^2 A` to the inertia of the
joint and :math:`g^2 d` to its damping.
"""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from ...base.checks import Array
from .couplings import moves
from .flags import disabled, is_driven
from .mujoco_numbers import FREE, HINGE, SLIDE
from .scene import Scene

#: Transmissions that act on one joint.
ON_JOINTS = int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)
#: Dynamics of an actuator by which its activation stays in the range of its control.
AS_TOLD = tuple(int(getattr(mujoco.mjtDyn, f"mjDYN_{name}")) for name in ("NONE", "FILTER", "FILTEREXACT"))


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


def motor_range(mj: mujoco.MjModel, j: int) -> tuple[float, float]:
    """The least and largest torque [N m], force [N], of the one actuator that acts on joint j; infinite if unknown.

    That is its gear times the range of its forces. The force of a motor is its control times a constant, so that the
    range of its controls is another one. Unknown are ranges without 0 inside, as of what only pulls, and what several
    actuators, or tendons, have together.
    """
    own = [i for i in _on_joints(mj) if int(mj.actuator_trnid[i, 0]) == j]
    if len(own) != 1 or mj.jnt_type[j] not in (HINGE, SLIDE) or j in _pulled(mj):
        return -np.inf, np.inf
    (i,), gear = own, float(mj.actuator_gear[own[0], 0])
    ends = _force_range(mj, i)
    low, high = sorted(gear * end for end in ends) if gear else (0.0, 0.0)
    return (low, high) if low < 0.0 < high else (-np.inf, np.inf)


def motor_limits(mj: mujoco.MjModel, joints: Mapping[int, str]) -> list[str]:
    """The joints (number, name) with an actuator of limited force of which no limit is read."""
    found = [
        joints[int(mj.actuator_trnid[i, 0])]
        for i in _on_joints(mj)
        if int(mj.actuator_trnid[i, 0]) in joints and _is_limited(mj, i)
    ]
    return list(dict.fromkeys(found))


def without_actuators(mj: mujoco.MjModel, joints: Mapping[int, str]) -> list[str]:
    """The joints (number, name) on which no actuator acts, by itself or by a tendon, if actuators act on others."""
    driven = _pulled(mj) | {int(mj.actuator_trnid[i, 0]) for i in _on_joints(mj)}
    own = [j for j in joints if mj.jnt_type[j] != FREE]
    return [joints[j] for j in own if j not in driven] if driven.intersection(own) else []


def _on_joints(mj: mujoco.MjModel) -> list[int]:
    """The actuators on single joints, but for those that the file disables."""
    return [i for i in range(mj.nu) if mj.actuator_trntype[i] in ON_JOINTS and is_driven(mj, i)]


def _pulled(mj: mujoco.MjModel) -> set[int]:
    """The joints on which an actuator acts by a tendon."""
    found = set[int]()
    for i in range(mj.nu):
        if mj.actuator_trntype[i] == int(mujoco.mjtTrn.mjTRN_TENDON) and is_driven(mj, i):
            first = int(mj.tendon_adr[mj.actuator_trnid[i, 0]])
            wraps = range(first, first + int(mj.tendon_num[mj.actuator_trnid[i, 0]]))
            found |= {int(mj.wrap_objid[k]) for k in wraps if mj.wrap_type[k] == int(mujoco.mjtWrap.mjWRAP_JOINT)}
    return found


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
    j = int(mj.actuator_trnid[i, 0])
    return _force_is_limited(mj, i) and not mj.jnt_actfrclimited[j] and np.isinf(motor_range(mj, j)[0])


def _force_is_limited(mj: mujoco.MjModel, i: int) -> bool:
    return _force_range(mj, i) != (-np.inf, np.inf)


def _force_range(mj: mujoco.MjModel, i: int) -> tuple[float, float]:
    """The least and largest force of an actuator, before its gear; infinite where it has no limit, or is disabled."""
    if not is_driven(mj, i):
        return -np.inf, np.inf
    low, high = (float(end) for end in mj.actuator_forcerange[i]) if mj.actuator_forcelimited[i] else (-np.inf, np.inf)
    fixed = mj.actuator_gaintype[i] == int(mujoco.mjtGain.mjGAIN_FIXED)
    motor = fixed and mj.actuator_biastype[i] == int(mujoco.mjtBias.mjBIAS_NONE) and mj.actuator_dyntype[i] in AS_TOLD
    clamped = mj.actuator_ctrllimited[i] and not disabled(mj, "CLAMPCTRL")
    if motor and clamped:
        least, most = sorted(float(mj.actuator_gainprm[i, 0] * end) for end in mj.actuator_ctrlrange[i])
        return max(low, least), min(high, most)
    return low, high
