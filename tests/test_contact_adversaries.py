"""Hierarchies like those of contacts, made to be degenerate: what the native solver claims, the certificate proves.

Cones at their apex (more faces meet than there are unknowns), feet whose points say the same motion several times,
torque limits and tasks that all but depend on what is above them, and tasks that ask for far too much.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hqp
from hqp import Hierarchy, Level, Solver, Status

HARD = Path(__file__).parent / "data" / "hard"
RECORDED = sorted(path.stem for path in HARD.glob("contacts_*.npz"))
#: What limits may be passed by, in the units of the rows, relative to their bounds and to x.
KEPT = 1e-9
#: Where the limits of one level contradict each other, and share what is missing.
CONTRADICTING = "contacts_g1_stalled_2"


def contacts(rng: np.random.Generator) -> Hierarchy:
    """A floating base of three directions, joints, and point contacts whose forces are unknowns, too."""
    joints, points, base = int(rng.integers(2, 7)), int(rng.integers(1, 5)), 3
    a, f, sides = base + joints, 3 * points, 4
    n = a + f
    half = rng.standard_normal((a, a)) * 10.0 ** rng.uniform(-1, 1, a)[:, None]
    M, J = half @ half.T + 0.1 * np.eye(a), rng.standard_normal((3, a))
    arms = 10.0 ** rng.uniform(-2, 0) * rng.standard_normal((points, 3, a))
    G = np.concatenate([J + arm for arm in arms])  # the points of one foot: close to each other
    motion = np.hstack([M, -G.T])
    normal = a + 3 * np.arange(points) + 2
    angles = 2.0 * np.pi * np.arange(sides) / sides
    face = np.column_stack([np.cos(angles), np.sin(angles), np.full(sides, -0.6)])
    cones = np.hstack([np.zeros((sides * points, a)), np.kron(np.eye(points), face)])
    torques = motion[base:]
    torques = np.concatenate([torques, torques + nearly(rng) * rng.standard_normal(torques.shape)])
    reach = 10.0 ** rng.uniform(-1, 2, joints)
    off = rng.random(points) < 0.3  # contacts that are off: no force
    rows = np.concatenate([motion[:base], np.hstack([G[:3], np.zeros((3, f))])])
    task = rng.standard_normal((3, len(rows))) @ rows + nearly(rng) * rng.standard_normal((3, n))
    task[0] += torques[0]
    far = 10.0 ** rng.uniform(0, 3)
    return Hierarchy(
        [
            Level.bounds(np.zeros(points), np.where(off, 0.0, 50.0), indices=normal, name="forces"),
            Level.equality(rows, rng.standard_normal(len(rows)) * (rng.random(len(rows)) < 0.7), name="motion"),
            Level(
                np.concatenate([torques, cones]),
                np.concatenate([-reach, -reach, np.full(len(cones), -np.inf)]),
                np.concatenate([reach, reach, np.zeros(len(cones))]),
                name="limits",
            ),
            Level.equality(task, far * rng.standard_normal(3), name="task"),
            Level.equality(np.eye(n)[rng.permutation(n)[: n - 2]], rng.standard_normal(n - 2), name="rest"),
        ],
        n=n,
    )


def nearly(rng: np.random.Generator) -> float:
    """How far from dependent: not at all, or 1e-13 to 1e-3."""
    return 0.0 if rng.random() < 0.2 else float(10.0 ** rng.uniform(-13, -3))


def claims(solution: hqp.Solution) -> str | None:
    """What is wrong with the status of an answer, if anything."""
    proof = solution.certify()
    if solution.status is Status.OPTIMAL and not proof.ok:
        return f"claimed, and refused: {proof}"
    if solution.status is Status.STALLED and proof.ok:
        return "certified, and not claimed"
    return None


@given(st.integers(0, 2**32 - 1))
def test_what_is_claimed_of_contacts_is_proved(seed: int) -> None:
    rng = np.random.default_rng(seed)
    hierarchy, solver = contacts(rng), Solver()
    assert claims(solver.solve(hierarchy)) is None
    moved = hierarchy.copy()
    for level in moved.levels[-2:]:  # and warm, where the tasks ask for something else
        level.lower[:] = level.upper[:] = level.lower + 0.1 * rng.standard_normal(len(level))
    assert claims(solver.solve(moved)) is None


@pytest.mark.parametrize("name", RECORDED)
def test_what_is_claimed_of_recorded_contacts_is_proved(name: str) -> None:
    """Robots that fall over their feet, motors and friction at their limits: limits kept, and claims proved."""
    hierarchy, x_ref = hqp.load(HARD / f"{name}.npz")
    solution = Solver().solve(hierarchy, x_ref)
    assert claims(solution) is None
    assert solution.status is Status.OPTIMAL
    if name == CONTRADICTING:
        return
    value = hierarchy.dense() @ solution.x
    size = hierarchy.row_norms() * np.linalg.norm(solution.x)
    end = hierarchy.pointers[3]
    passed = np.maximum(value - hierarchy.upper, hierarchy.lower - value)[:end]
    bound = np.minimum(np.abs(hierarchy.upper), np.abs(hierarchy.lower))[:end]
    assert (passed <= KEPT * (bound + size[:end])).all()
