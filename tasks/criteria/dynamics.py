"""Checks of a robot's dynamics for criteria of energy and torque: ``mass_matrix(q)`` and ``bias(q, v)``."""

from __future__ import annotations

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.robot import Robot, base, integrate, mass_matrix, neutral


def check_fixed(robot: Robot, what: str) -> None:
    """Refuse a robot whose base no torque moves.

    Raises
    ------
    InvalidInput
    """
    if base(robot):
        raise InvalidInput(f"{what}: takes a robot with a fixed base; no torque moves the floating base of {robot!r}")


def check_definite(robot: Robot, what: str) -> None:
    """Refuse a robot with links without mass, by M near the neutral configuration, which may be a special one.

    Raises
    ------
    InvalidInput
    """
    if not np.isfinite(root(robot, integrate(robot, neutral(robot), np.full(robot.nv, 0.1)))).all():
        raise InvalidInput(f"{what}: takes a positive definite mass matrix; links of {robot!r} have no mass")


def root(robot: Robot, q: Array) -> Array:
    """The upper triangles ``L^T`` of ``M = L L^T``, shape (..., nv, nv); NaN where an M is not positive definite."""
    inertia = mass_matrix(robot)
    assert inertia is not None  # checked before the first tick
    M = inertia(q)
    try:
        return np.asarray(np.linalg.cholesky(M).swapaxes(-1, -2))
    except np.linalg.LinAlgError:
        return np.full(M.shape, np.nan)
