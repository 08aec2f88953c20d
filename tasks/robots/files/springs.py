"""Springs of the joints of an MJCF."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from .flags import disabled
from .mujoco_numbers import HINGE, SLIDE


def springs(mj: mujoco.MjModel, joints: Mapping[int, str]) -> dict[str, tuple[float, float]]:
    """The linear springs of these joints (number, name): their stiffness [N m/rad], [N/m], and where they rest."""
    own = [j for j in joints if mj.jnt_type[j] in (HINGE, SLIDE) and is_sprung(mj, j)]
    return {
        joints[j]: (float(mj.jnt_stiffness[j]), float(mj.qpos_spring[mj.jnt_qposadr[j]]))
        for j in own
        if not np.any(mj.jnt_stiffnesspoly[j])
    }


def is_sprung(mj: mujoco.MjModel, j: int) -> bool:
    """Whether a joint has a spring of any kind."""
    return not disabled(mj, "SPRING") and bool(mj.jnt_stiffness[j] or np.any(mj.jnt_stiffnesspoly[j]))
