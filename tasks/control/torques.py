"""The joint torques that given accelerations require."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.robot import Robot, RobotState, check_fixed_base, inverse_dynamics
from ..rows.hierarchy_writer import HierarchyWriter
from ..rows.part import Command, Stack
from .contacts import check_torques, has_dynamics, joint_torques

#: Joint torques [N m] by the rows of this tick, the state, and x.
Torques: TypeAlias = Callable[[HierarchyWriter, RobotState, Array, bool], Array]


class RobotTorques:
    """``M(q) a + b(q, v)``, as the robot tells it.

    Parameters
    ----------
    inverse_dynamics : callable
        Of q, v and a.
    """

    def __init__(self, inverse_dynamics: Callable[[Array, Array, Array], Array]) -> None:
        self._inverse_dynamics = inverse_dynamics

    def __call__(self, rows: HierarchyWriter, state: RobotState, x: Array, valid: bool) -> Array:
        return _finite(self._inverse_dynamics(state.q, state.v, x), True) if valid else np.zeros_like(x)


def contact_torques(rows: HierarchyWriter, state: RobotState, x: Array, valid: bool) -> Array:
    """``M a + b - G^T f``, where the stack has the motion equation: of its own arrays."""
    return _finite(joint_torques(rows, x), valid)


def torques_of(robot: Robot, stack: Stack, order: Command) -> Torques:
    """How torques are computed for this robot and stack; zero where the numbers of a tick are not valid or not finite.

    What goes to a motor is finite, whatever a sensor says.

    Raises
    ------
    InvalidInput
        If the order gives no accelerations, the robot cannot tell its torques, or forces of a contact are unknown.
    """
    asked = "order = 'torque'" if order == "torque" else "torque = True"
    if order == "velocity":
        raise InvalidInput(f"torque = True, but order = {order!r} gives no accelerations; it must be False")
    check_torques(stack)
    if has_dynamics(stack):
        return contact_torques
    check_fixed_base(robot, asked)
    method = inverse_dynamics(robot)
    if method is None:
        raise InvalidInput(f"{asked}, but {robot!r} has no inverse_dynamics(q, v, a)")
    return RobotTorques(method)


def _finite(tau: Array, valid: bool) -> Array:
    return tau if valid and np.isfinite(tau).all() else np.zeros_like(tau)
