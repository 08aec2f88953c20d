"""The joint torques that given accelerations require."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.robot import Robot, RobotState, base, check_fixed_base, check_motors, inverse_dynamics
from ..rows.hierarchy_writer import HierarchyWriter
from ..rows.part import Command, Stack
from ..rows.site import Workspace
from .contacts import check_torques, has_dynamics

#: Function that gives joint torques [N m] from the rows of this tick, the state, x, and whether they are valid: zero if
#: not, and None where they should be, but are not finite.
Torques: TypeAlias = Callable[[HierarchyWriter, RobotState, Array, bool], Array | None]


class RobotTorques:
    """``M(q) a + b(q, v)``, computed by the robot.

    Parameters
    ----------
    inverse_dynamics : callable
        Function of q, v and a.
    """

    def __init__(self, inverse_dynamics: Callable[[Array, Array, Array], Array]) -> None:
        self._inverse_dynamics = inverse_dynamics

    def __call__(self, rows: HierarchyWriter, state: RobotState, x: Array, valid: bool) -> Array | None:
        if not valid:
            return np.zeros_like(x)
        tau = self._inverse_dynamics(state.q, state.v, x)
        return tau if np.isfinite(tau).all() else None


class ContactTorques:
    """``M a + b - G^T f`` of all joints that have a motor, from the arrays of this tick, by one loop."""

    def __init__(self) -> None:
        self._shared: Workspace | None = None

    def __call__(self, rows: HierarchyWriter, state: RobotState, x: Array, valid: bool) -> Array | None:
        if rows.shared is not self._shared:
            self._come_to(rows.shared)
        if not valid:
            return np.zeros_like(self._torques)
        self._x[:] = x
        return self._torques.copy() if self._compute() else None

    def _come_to(self, shared: Workspace) -> None:
        """Make the loop for the arrays of this workspace."""
        from ..base.loops import Call
        from ..contacts.kernels.dynamics import compute_torques

        n, first = shared.n, base(shared.robot)
        self._x, self._torques = np.zeros(shared.unknowns.n), np.zeros(n - first)
        arrays = shared.blocks.mass_matrix(), shared.blocks.bias(), shared.wrenches, 0, self._x, self._torques
        self._compute = Call(compute_torques, n, shared.unknowns.n, first, n - first, *arrays).run
        self._shared = shared


def torques_of(robot: Robot, stack: Stack, order: Command) -> Torques:
    """The function that computes torques for this robot and stack.

    Torques sent to motors are always finite: zero if the numbers of a tick are invalid, as they are without torques.

    Raises
    ------
    InvalidInput
        If the order gives no accelerations, the robot cannot compute torques, or forces of a contact are unknown.
    """
    asked = "order = 'torque'" if order == "torque" else "torque = True"
    if order == "velocity":
        raise InvalidInput(f"torque = True, but order = {order!r} gives no accelerations; it must be False")
    check_torques(stack)
    if not any(part.limited == "torque" for part in stack):
        check_motors(robot, asked)
    if has_dynamics(stack):
        return ContactTorques()
    check_fixed_base(robot, asked)
    method = inverse_dynamics(robot)
    if method is None:
        raise InvalidInput(f"{asked}, but {robot!r} has no inverse_dynamics(q, v, a)")
    return RobotTorques(method)
