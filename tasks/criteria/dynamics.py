"""Checks of a robot's dynamics for criteria of energy and torque: ``mass_matrix(q)`` and ``bias(q, v)``."""

from __future__ import annotations

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..robots.robot import Robot, base, integrate, joint_names, mass_matrix, neutral

#: A motion with so little of the largest kinetic energy has none; a joint with so much of it takes part.
EMPTY, PART = 1e-12, 0.1


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
        It names the joints that take part in motions without kinetic energy.
    """
    q = integrate(robot, neutral(robot), np.full(robot.nv, 0.1))
    if np.isfinite(root(robot, q)).all():
        return
    inertia = mass_matrix(robot)
    assert inertia is not None  # checked before
    M = np.asarray(inertia(q))
    energies, motions = np.linalg.eigh(M)
    none = energies <= max(EMPTY * energies[-1], energies[0])
    shares = np.linalg.norm(motions[:, none], axis=1)
    joints = ", ".join(name for name, share in zip(joint_names(robot), shares, strict=True) if share > PART)
    told = f"takes a positive definite mass matrix, and {robot!r} can move without any mass: {joints}"
    raise InvalidInput(f"{what}: {told}")


def root(robot: Robot, q: Array) -> Array:
    """The upper triangles ``L^T`` of ``M = L L^T``, shape (..., nv, nv); NaN where an M is not positive definite."""
    inertia = mass_matrix(robot)
    assert inertia is not None  # checked before the first tick
    M = inertia(q)
    try:
        return np.asarray(np.linalg.cholesky(M).swapaxes(-1, -2))
    except np.linalg.LinAlgError:
        return np.full(M.shape, np.nan)
