"""What MuJoCo models, and the inertias and torques of the robot do not include: told when it is loaded."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from .couplings import moves
from .flags import switched_off
from .motors import limits_elsewhere, motor_limits, other_rotors, without_actuators
from .mujoco_numbers import dofs
from .scene import Scene, body_names
from .springs import is_sprung, springs


def unmodelled(mj: mujoco.MjModel, scene: Scene, joints: Mapping[int, str], closed: bool) -> list[str]:
    """Forces and inertias of MuJoCo that the robot does not have, with what has them.

    Parameters
    ----------
    mj : mujoco.MjModel
    scene : Scene
    joints : dict of int to str
        The joints of the robot.
    closed : bool
        Whether it has closed chains, in which joints without a motor are common.
    """
    bodies = body_names(mj)
    tendons = [t for t in range(mj.ntendon) if moves(mj, t, scene, joints)]
    own = {j: dofs(mj, j) for j in joints}
    counted = springs(mj, joints)
    told = [
        ("springs of the joints", [name for j, name in joints.items() if is_sprung(mj, j) and name not in counted]),
        ("gravity compensation of the bodies", [bodies[body] for body in scene.bodies if mj.body_gravcomp[body]]),
        (
            "springs, dampers, friction and armature of the tendons",
            [mj.tendon(t).name or f"number {t}" for t in tendons if _resists(mj, t)],
        ),
        ("damping that is not linear of the joints", [joints[j] for j in joints if np.any(mj.dof_dampingpoly[own[j]])]),
        ("armature and damping of the actuators", other_rotors(mj)),
        ("the forces of", ["the medium"] if mj.opt.density or mj.opt.viscosity else []),
    ]
    lines = [f"{thing} {', '.join(names)} (torques do not count them)" for thing, names in told if names]
    if counted:
        lines.append(f"springs of the joints {', '.join(counted)} (Dynamics(springs=robot.springs) counts them)")
    passive = without_actuators(mj, joints) if closed else []
    if passive:
        lines.append(f"that no actuator drives the joints {', '.join(passive)} (a torque_limit of 0 of each says so)")
    motors = motor_limits(mj, joints)
    if motors:
        lines.append(f"limits of the motors of the joints {', '.join(motors)} (torque_limit= gives them)")
    elsewhere = limits_elsewhere(mj, scene, joints)
    if elsewhere:
        lines.append(f"limits of the forces of {', '.join(elsewhere)} (torques of the joints do not keep them)")
    return lines + switched_off(mj, joints)


def _resists(mj: mujoco.MjModel, t: int) -> bool:
    """Whether a tendon has forces or an inertia of its own."""
    numbers = mj.tendon_stiffness[t], mj.tendon_armature[t], mj.tendon_damping[t], mj.tendon_frictionloss[t]
    return any(np.any(number) for number in (*numbers, mj.tendon_stiffnesspoly[t], mj.tendon_dampingpoly[t]))
