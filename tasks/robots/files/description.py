"""The result of reading a model file, whatever its format."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pinocchio as pin

from ...base.checks import Array
from ..closure import Closure
from .ties import Tie

#: The joint of a base that the file does not have, by name and kind.
BASE_JOINT = "root_joint"
BASES = {"planar": pin.JointModelPlanar, "floating": pin.JointModelFreeFlyer}


@dataclass
class Description:
    """The contents of a model file: the Pinocchio model, joints that follow others, closed chains.

    Attributes
    ----------
    model : pinocchio.Model
        Every joint on its own, tied or not; configurations that the file names as its reference configurations.
    neutral : array, shape (nq,)
        The zero configuration of the file.
    ties : list of Tie
        Joints that follow others.
    fixed : tuple of str
        Fixed joints of the file, which are not in the model.
    springs : dict of str to (float, float)
        Of joints: stiffness [N m/rad], [N/m], and position without force [rad], [m].
    closures : tuple of Closure
        Frames that it holds together, beside its joints.
    scene : mujoco.MjModel or None
        What MuJoCo compiled.
    left_out : tuple of str
        Other contents of the file, and why they are not part of the robot.
    """

    model: pin.Model
    neutral: Array
    ties: list[Tie] = field(default_factory=list)
    fixed: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    closures: tuple[Closure, ...] = ()
    scene: Any = None
    springs: dict[str, tuple[float, float]] = field(default_factory=dict)
