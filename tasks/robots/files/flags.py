"""What the flags of an MJCF switch off: MuJoCo has none of it, and so has the robot."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from .mujoco_numbers import HINGE, SLIDE, dofs


def disabled(mj: mujoco.MjModel, flag: str) -> bool:
    """Whether the file disables this: ``"LIMIT"`` or another of MuJoCo's ``mjtDisableBit``.

    Limits, equalities and dry friction are constraints, which are disabled all together, too.
    """
    bits = int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
    if flag in ("LIMIT", "EQUALITY", "FRICTIONLOSS"):
        bits |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    return bool(mj.opt.disableflags & bits)


def has_range(mj: mujoco.MjModel, j: int) -> bool:
    """Whether the range of a joint is a limit."""
    return bool(mj.jnt_limited[j]) and not disabled(mj, "LIMIT")


def is_driven(mj: mujoco.MjModel, i: int) -> bool:
    """Whether actuator i has any force: neither all of them are disabled, nor its group, one of the first 31."""
    group = int(mj.actuator_group[i])
    off = 0 <= group < 31 and mj.opt.disableactuator >> group & 1
    return not (off or disabled(mj, "ACTUATION"))


def switched_off(mj: mujoco.MjModel, joints: Mapping[int, str]) -> list[str]:
    """What the robot of these joints (number, name) would have without the flags of the file."""
    single = [j for j in joints if mj.jnt_type[j] in (HINGE, SLIDE)]
    places = [dof for j in joints for dof in dofs(mj, j)]
    has = {
        "LIMIT": bool(mj.jnt_limited[single].any() or mj.tendon_limited.any()),
        "EQUALITY": bool(mj.eq_active0.any()),
        "SPRING": bool(mj.jnt_stiffness[list(joints)].any()),
        "DAMPER": bool(mj.dof_damping[places].any() or np.any(mj.actuator_damping)),
        "FRICTIONLOSS": bool(mj.dof_frictionloss[places].any()),
    }
    names = {"LIMIT": "ranges of joints", "EQUALITY": "equalities", "SPRING": "springs", "DAMPER": "damping"}
    off = [names.get(flag, "dry friction") for flag, some in has.items() if some and disabled(mj, flag)]
    told = [f"what the flags of the file disable: {', '.join(off)}"] if off else []
    idle = [mj.actuator(i).name or f"number {i}" for i in range(mj.nu) if not is_driven(mj, i)]
    if idle:
        told.append(f"the actuators that the file disables: {', '.join(idle)} (limits of their forces are not read)")
    return told
