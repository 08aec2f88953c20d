"""The support polygon: the hull of contact points, whatever round-off makes of points that stand side by side."""

from __future__ import annotations

import numpy as np
import pytest

from hqp.kernels.compile import plain
from tasks.contacts.kernels import balance

MOST = 16
#: How far a corner may be off that is left out [m].
CLOSE = 3e-5


def hull(points: np.ndarray) -> np.ndarray:
    """The corners of these points, by the loop of the support."""
    x, y = np.array(points, dtype=float).T.copy()
    out_x, out_y = np.zeros((2, 2 * len(points) + 4))
    size = interpreted("hull")(x, y, len(points), out_x, out_y)
    return np.column_stack([out_x, out_y])[:size]


def interpreted(name: str):
    """A loop, and those that it calls, run by the interpreter."""
    own = dict(vars(balance))
    for other in ("turn", "without_flat", name):
        function = plain(own[other])
        own[other] = type(function)(function.__code__, own, other)
    return own[name]


def feet(rng: np.random.Generator) -> np.ndarray:
    """Soles side by side or one before the other, at any angle, and points that were lifted or slid by round-off."""
    sole = np.array([(x, y) for x in (-0.05, 0.12) for y in (-0.03, 0.03)])
    apart = rng.choice([(0.0, 0.24), (0.17, 0.0), (0.0, 0.06), (0.4, 0.2)])
    points = np.concatenate([sole, sole + apart, sole[: rng.integers(0, 5)] + 2.0 * apart])
    angle = rng.choice([0.0, 0.5 * np.pi, np.arctan(balance.ASLANT), rng.uniform(0.0, 6.0)])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    noise = rng.choice([0.0, 1e-16, 1e-13, 1e-10, 1e-8, 1e-6, 1e-4])
    return rng.permutation(points @ turn.T + noise * rng.standard_normal(points.shape))


@pytest.mark.parametrize("seed", range(300))
def test_it_reaches_as_far_as_the_points_in_every_direction(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = feet(rng)
    corners = hull(points)
    assert len(corners) >= 3
    angles = np.concatenate([np.linspace(0.0, 2.0 * np.pi, 73), rng.uniform(0.0, 2.0 * np.pi, 30)])
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    np.testing.assert_allclose((corners @ ways.T).max(axis=0), (points @ ways.T).max(axis=0), rtol=0.0, atol=CLOSE)
    a, b, c = corners, np.roll(corners, -1, axis=0), np.roll(corners, -2, axis=0)
    turns = (b - a)[:, 0] * (c - b)[:, 1] - (b - a)[:, 1] * (c - b)[:, 0]
    assert turns.min() > 0.0  # convex, counter-clockwise


@pytest.mark.parametrize("noise", [0.0, 1e-13, 1e-10])
def test_soles_side_by_side_have_four_edges(noise: float) -> None:
    rng = np.random.default_rng(5)
    sole = np.array([(x, y) for x in (-0.05, 0.12) for y in (-0.03, 0.03)])
    both = np.concatenate([sole, sole + np.array([0.0, 0.24])])
    for _ in range(50):
        assert len(hull(both + noise * rng.standard_normal(both.shape))) == 4


@pytest.mark.parametrize("angle", [0.0, 0.5 * np.pi, 1.2, np.arctan(-1.0 / balance.ASLANT)])
@pytest.mark.parametrize("noise", [0.0, 1e-13, 1e-10])
def test_lines_and_points(angle: float, noise: float) -> None:
    rng = np.random.default_rng(1)
    along = np.array([np.cos(angle), np.sin(angle)])
    line = np.outer([0.3, 0.0, 0.1, 0.3], along) + noise * rng.standard_normal((4, 2))
    ends = hull(line)
    assert len(ends) == 2
    np.testing.assert_allclose(np.sort(ends @ along), [0.0, 0.3], atol=1e-9)
    assert len(hull(np.full((3, 2), 0.7) + noise * rng.standard_normal((3, 2)))) == 1
    assert len(hull(np.zeros((1, 2)))) == 1
