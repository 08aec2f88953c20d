"""Saturated whole-body problems: accelerations and contact forces of a robot that loses its balance.

A floating base with 29 joints on two soles, drawn at random: the unknowns are 35 accelerations and the forces of eight
points. The equations of motion and of the contacts come first, friction cones and torque limits second, and the tasks
ask for far more than these allow, so that dozens of inequalities are active, many of them at the apex of a cone.
"""

from __future__ import annotations

import numpy as np

from hqp import Hierarchy, Level
from hqp.arrays import Array

from .family import Family, drawn

#: Velocities of the base and of the joints; contact points, of three forces each.
BASE, JOINTS, POINTS = 6, 29, 8
NV, FORCES = BASE + JOINTS, 3 * POINTS
N = NV + FORCES
#: Coefficient of friction; mass times gravity over the unit of force; largest torque; how far the tasks overshoot.
FRICTION, WEIGHT, TORQUE, OVERSHOOT = 0.7, 9.81, 4.0, 25.0


def _cones() -> Array:
    """Four faces a point: a force within them pushes, and does not slide."""
    face = np.array([[1.0, 0.0, -FRICTION], [-1.0, 0.0, -FRICTION], [0.0, 1.0, -FRICTION], [0.0, -1.0, -FRICTION]])
    return np.hstack([np.zeros((4 * POINTS, NV)), np.kron(np.eye(POINTS), face)])


def saturated(rng: np.random.Generator) -> Hierarchy:
    """One draw."""
    B = rng.standard_normal((NV, NV)) / np.sqrt(NV)
    M = B @ B.T + 0.1 * np.eye(NV)
    soles = rng.standard_normal((12, NV)) / np.sqrt(NV)
    spread = np.kron(np.eye(2), rng.standard_normal((FORCES // 2, 6)))  # points of a sole from its six motions
    bias = np.concatenate([[0.0, 0.0, WEIGHT, 0.0, 0.0, 0.0], 0.3 * rng.standard_normal(JOINTS)])
    motion = np.hstack([M, -(spread @ soles).T])  # M a + h - J' f = [0, torques]
    contact = np.hstack([soles, np.zeros((12, FORCES))])
    dynamics = Level.equality(
        np.vstack([motion[:BASE], contact]), np.concatenate([-bias[:BASE], 0.1 * rng.standard_normal(12)])
    )
    cones = _cones()
    torques, off = motion[BASE:], bias[BASE:]
    limits = Level(
        np.vstack([cones, torques]),
        np.concatenate([np.full(len(cones), -np.inf), -TORQUE - off]),
        np.concatenate([np.zeros(len(cones)), TORQUE - off]),
    )
    tasks = []
    for rows in (3, 6):
        J = np.hstack([rng.standard_normal((rows, NV)) / np.sqrt(NV), np.zeros((rows, FORCES))])
        tasks.append(Level.equality(J, OVERSHOOT * rng.standard_normal(rows)))
    still = np.delete(np.eye(N), np.arange(BASE), axis=0)
    rest = Level.equality(still, 0.5 * rng.standard_normal(len(still)), weights=np.repeat([1.0, 0.1], [JOINTS, FORCES]))
    return Hierarchy([dynamics, limits, *tasks, rest])


WHOLE_BODY = Family(
    "control",
    "WB",
    f"n = {N}: 18 = | {4 * POINTS} <=, {JOINTS} <> | 3 = | 6 = | {N - BASE} =, saturated",
    drawn(saturated),
    feasible=True,
)
