"""What criteria of energy and torque ask of a robot: ``mass_matrix(q)`` and ``bias(q, v)``, and masses in all links."""

from __future__ import annotations

import numpy as np

from hqp import InvalidInput

from .._checks import Array
from ..robots.robot import Robot, integrate, neutral


def check_methods(robot: Robot, what: str, *methods: str) -> None:
    """Refuse a robot that lacks one of these methods.

    Raises
    ------
    InvalidInput
        Names the task and the method.
    """
    for method in methods:
        if not hasattr(robot, method):
            raise InvalidInput(f"{what}: takes a robot that has {method}, and {robot!r} has none")


def check_fixed(robot: Robot, what: str) -> None:
    """Refuse a robot whose base no torque moves.

    Raises
    ------
    InvalidInput
    """
    if getattr(robot, "base", 0):
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
    M = robot.mass_matrix(q)  # type: ignore[attr-defined]
    try:
        return np.asarray(np.linalg.cholesky(M).swapaxes(-1, -2))
    except np.linalg.LinAlgError:
        return np.full(M.shape, np.nan)
