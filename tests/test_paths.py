"""Paths: their motion is that of their positions, from rest to rest, and they go where they say."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from hqp import InvalidInput
from tasks import (
    Chain,
    Circle,
    Fixed,
    Line,
    OrientationTask,
    Polygon,
    Polynomial,
    PositionTask,
    Trajectory,
    cubic,
    cycloid,
    harmonic,
    quintic,
)
from tasks.targets.paths import Path

LAWS = [cubic, quintic, harmonic, cycloid]


class Spiral(Path):
    """A curve of one's own: r = s (cos 5s, sin 5s)."""

    def curve(self, s):
        arm, cross = np.array([np.cos(5 * s), np.sin(5 * s)]), np.array([-np.sin(5 * s), np.cos(5 * s)])
        return s * arm, arm + 5 * s * cross, 10 * cross - 25 * s * arm


@st.composite
def paths(draw, kinds=("line", "circle", "spiral", "polygon", "chain")):
    """Any path in the plane, of size and duration about one."""
    kind = draw(st.sampled_from(kinds))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    duration, law = rng.uniform(0.5, 2.0), draw(st.sampled_from(LAWS))
    match kind:
        case "line":
            return Line(rng.uniform(-1, 1, 2), rng.uniform(-1, 1, 2), duration, law)
        case "circle":
            start, turn = rng.uniform(-7, 7, 2)
            return Circle(rng.uniform(-1, 1, 2), rng.uniform(0.1, 1), duration, start=start, turn=turn, timing=law)
        case "spiral":
            return Spiral(duration, law)
        case "polygon":
            corners = rng.uniform(-1, 1, (draw(st.integers(2, 5)), 2))
            return Polygon(corners, duration, law, closed=draw(st.booleans()))
    here, there, back = rng.uniform(-1, 1, (3, 2))
    fly_by = rng.uniform(-1, 1, 2)
    return Chain(
        [
            Line(here, there, duration, law),
            Polynomial([there, [0.0, 0.0]], [back, fly_by], 0.7),
            Polynomial([back, fly_by], [here, [0.0, 0.0]], 0.6),
        ]
    )


def borders(path):
    """Where one piece ends and the next begins [s]."""
    if not isinstance(path, Chain):
        return np.array([0.0, path.duration])
    return np.cumsum([0.0, *(piece.duration for piece in path.pieces)])


@given(paths(), st.floats(0, 1))
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(path, share):
    h, t = 1e-5, share * path.duration
    if np.abs(borders(path) - t).min() <= h:  # there the acceleration jumps
        return
    before, (_, velocity, acceleration), after = path(t - h), path(t), path(t + h)
    np.testing.assert_allclose(velocity, (after[0] - before[0]) / (2 * h), rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(acceleration, (after[1] - before[1]) / (2 * h), rtol=1e-5, atol=1e-5)


@given(paths(), st.floats(0, 1))
def test_position_and_velocity_have_no_jumps(path, share):
    for t in [share * path.duration, *borders(path)]:
        h = 1e-9
        (before, slow, _), (after, fast, _) = path(t - h), path(t + h)
        np.testing.assert_allclose(before, after, atol=1e-6)
        np.testing.assert_allclose(slow, fast, atol=1e-4)


@given(paths())
def test_at_rest_before_the_start_and_from_the_end_on(path):
    T = path.duration
    first, last = path(0.0)[0], path(T)[0]
    for times, place in ((-T, -1e-9, -np.inf), first), ((T, T + 1e-9, 9 * T, np.inf), last):
        for t in times:
            position, velocity, acceleration = path(t)
            np.testing.assert_array_equal(position, place)
            assert not velocity.any()
            assert not acceleration.any()


@given(paths())
def test_no_time_is_no_place(path):
    assert isinstance(path, Trajectory)
    assert all(np.isnan(part).all() and part.shape == (2,) for part in path(np.nan))


@given(paths(kinds=("line",)), st.floats(0, 1))
def test_a_line_is_straight_and_ends_at_its_ends(line, share):
    t = share * line.duration
    s = line.timing(share * line.duration / line.duration)[0]
    np.testing.assert_allclose(line(t)[0], (1 - s) * line.start + s * line.end, atol=1e-14)
    np.testing.assert_array_equal(line(0.0)[0], line.start)
    np.testing.assert_allclose(line(line.duration)[0], line.end, atol=1e-15)


def test_the_line_of_eq_3_26():
    line = Line([1.0, 0.0], [1.0, 1.0], 60.0)
    np.testing.assert_allclose(line(15.0)[0], [1.0, 3 * 0.25**2 - 2 * 0.25**3])
    np.testing.assert_allclose(line(30.0)[1], [0.0, 1.5 / 60.0])


@given(paths(kinds=("line",)), st.floats(0, 1, exclude_max=True))
def test_a_cubic_line_is_the_polynomial_between_rests(line, share):
    line = Line(line.start, line.end, line.duration)
    polynomial = Polynomial([line.start, [0.0, 0.0]], [line.end, [0.0, 0.0]], line.duration)
    for a, b in zip(line(share * line.duration), polynomial(share * line.duration), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-11)


@given(paths(kinds=("circle",)), st.floats(0, 1))
def test_a_circle_stays_on_its_radius_and_goes_its_turn(circle, share):
    position, velocity, _ = circle(share * circle.duration)
    arm = position - circle.center
    assert np.hypot(*arm) == pytest.approx(circle.radius, rel=1e-13)
    assert arm @ velocity == pytest.approx(0.0, abs=1e-12)
    assert (arm[0] * velocity[1] - arm[1] * velocity[0]) * circle.turn >= 0.0  # counter-clockwise if positive
    angle = circle.start + circle.turn
    end = circle.center + circle.radius * np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(circle(circle.duration)[0], end, atol=1e-14)


def test_a_circle_goes_once_around_unless_told_otherwise():
    circle = Circle([1.0, 0.5], 0.5, 4.0)
    places = [[1.5, 0.5], [0.5, 0.5], [1.5, 0.5]]
    np.testing.assert_allclose([circle(t)[0] for t in (0.0, 2.0, 4.0)], places, atol=1e-15)
    assert circle(2.0)[1][1] < 0.0


@given(paths(kinds=("polygon",)))
def test_a_polygon_rests_at_each_corner_at_its_time(polygon):
    sides = len(polygon.corners) - (not polygon.closed)
    assert len(polygon.pieces) == sides
    corners = [*polygon.corners, polygon.corners[0]][: sides + 1]
    for k, corner in enumerate(corners):
        position, velocity, _ = polygon(k * polygon.duration / sides)
        np.testing.assert_allclose(position, corner, atol=1e-14)
        np.testing.assert_allclose(velocity, 0.0, atol=1e-12)


@given(paths(kinds=("polygon",)), st.floats(0, 1, exclude_max=True), st.integers(0, 4))
def test_a_polygon_is_the_chain_of_its_sides(polygon, u, k):
    side = polygon.pieces[k % len(polygon.pieces)]
    begin = (k % len(polygon.pieces)) * side.duration
    for a, b in zip(polygon(begin + u * side.duration)[:2], side(u * side.duration)[:2], strict=True):
        np.testing.assert_allclose(a, b, atol=1e-11)


def test_a_polygon_lasts_as_long_as_it_says():
    """Whatever the sum of its sides is rounded to."""
    for n in range(2, 30):
        polygon = Polygon(np.arange(2.0 * n).reshape(n, 2), 0.7)
        assert polygon.duration == 0.7
        assert not np.any(polygon(0.7)[1:])


def test_each_piece_of_a_chain_has_its_own_clock():
    arc = Circle([0.0, 0.0], 1.0, 2.0, turn=np.pi)
    chain = Chain([Line([3.0, 0.0], [1.0, 0.0], 4.0), arc, Line([-1.0, 0.0], [0.0, 0.0], 1.0)])
    assert chain.duration == 7.0
    np.testing.assert_array_equal(chain(5.5), arc(1.5))
    np.testing.assert_array_equal(chain(6.0)[0], [-1.0, 0.0])
    outer = Chain([chain, Line([0.0, 0.0], [3.0, 0.0], 1.0)])
    np.testing.assert_array_equal(outer(5.5), arc(1.5))


def test_pieces_meet_within_round_off_of_their_size_even_at_the_origin():
    around = Circle([0.5, 0.0], 0.5, 1.0, start=np.pi)
    Chain([around, around, Line([0.0, 0.0], [1.0, 0.0], 1.0)])
    small = 1e-7
    with pytest.raises(InvalidInput, match="they must meet"):
        Chain([Line([0.0, 0.0], [small, 0.0], 1.0), Line([small + 1e-12, 0.0], [0.0, 0.0], 1.0)])


def test_any_trajectory_with_a_duration_is_a_piece():
    class Sweep:
        duration = 2.0

        def __call__(self, t):
            return np.array([t]), np.array([1.0]), np.array([0.0])

    chain = Chain([Sweep(), Line(2.0, 3.0, 1.0)])
    np.testing.assert_array_equal(chain(1.5), [[1.5], [1.0], [0.0]])
    assert OrientationTask(chain, gain=1.0).target is chain


def test_the_repr_is_what_makes_it():
    triangle = Polygon([[0, 0], [1, 0], [0, 1]], 3.0)
    for path in (
        Line([0, 0], [1, 1], 2.0),
        Circle([1, 0], 0.5, 2.0, start=0.5, turn=-3.0),
        triangle,
        Polygon(triangle.corners, 3.0, closed=False),
        Chain([triangle, Line([0, 0], [1, 1], 2.0)]),
    ):
        again = eval(repr(path))
        assert repr(again) == repr(path)
        np.testing.assert_array_equal(again(1.3), path(1.3))


def test_a_curve_of_ones_own_must_be_defined():
    with pytest.raises(NotImplementedError, match=r"Path must define curve\(s\)"):
        Path(1.0)(0.5)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Line([0, 0], [1, 1], 0.0), "line: duration = 0.0 s must be positive"),
        (lambda: Line([0, 0], [1, 1], np.inf), "duration = inf"),
        (lambda: Line([0, 0], [1, 1, 1], 1.0), r"start has shape \(2,\), end \(3,\)"),
        (lambda: Line([0, np.nan], [1, 1], 1.0), r"start\[1\] = nan"),
        (lambda: Line([0, 0], [1, 1], 1e300), r"duration = 1e\+300 s must be positive and at most 1e\+15"),
        (lambda: Line([0, 0], [1, 1], 1.0, timing=3), "line: timing = 3 is a int; it must be a function"),
        (lambda: Circle([0, 0, 0], 1.0, 1.0), r"circle: center has shape \(3,\); it must be \(2,\)"),
        (lambda: Circle([0, 0], -1.0, 1.0), "circle: radius = -1.0 m must be positive"),
        (lambda: Circle([0, 0], 1.0, 0.0), "circle: duration = 0.0 s must be positive"),
        (lambda: Circle([0, 0], 1.0, 1.0, start=np.nan), "circle: start = nan must be finite"),
        (lambda: Circle([0, 0], 1.0, 1.0, turn=np.inf), "circle: turn = inf must be finite"),
        (
            lambda: Circle([0, 0], 1.0, 1.0, turn=-1e16),
            r"circle: turn = -1e\+16 must be at most 1e\+15 in size",
        ),
        (lambda: Circle([0, 0], 1.0, 1.0, timing="cubic"), "circle: timing = 'cubic' is a str"),
        (lambda: Polygon([0, 1, 2], 1.0), r"polygon: corners has shape \(3,\); it must be \(n, rows\) with n >= 2"),
        (lambda: Polygon([[0, 1]], 1.0), r"polygon: corners has shape \(1, 2\)"),
        (lambda: Polygon([[0, 1], [np.nan, 0]], 1.0), r"polygon: corners\[1, 0\] = nan"),
        (lambda: Polygon([[0, 1], [1, 0]], -1.0), r"polygon: duration = -1.0 s must be positive"),
        (lambda: Polygon([[0, 1], [1, 0]], 1.0, 3), r"polygon: timing = 3 is a int"),
        (lambda: Polygon([[0, 1], [1, 0]], 1.0, closed=1), "polygon: closed = 1 must be True or False"),
        (lambda: Polygon([[0, 1], [0, 1], [1, 0]], 1.0), r"corners 0 and 1 are both \[0.0, 1.0\]; they must differ$"),
        (lambda: Polygon([[0, 1], [1, 0], [0, 1]], 1.0), "corners 2 and 0 .* a closed polygon returns to corner 0"),
        (lambda: Chain([]), r"chain: pieces = \[\] must be a list of trajectories, at least one"),
        (lambda: Chain(Line([0], [1], 1.0)), r"chain: pieces = Line\(.*\) must be a list"),
        (lambda: Chain([Fixed([0.0])]), r"chain: piece 0, \[0.0\], has no duration"),
        (lambda: Chain([Line([0], [1], 1.0), None]), "chain: piece 1, None, has no duration"),
        (
            lambda: Chain([Line([0], [1], 1.0), Line([1.001], [2], 3.0)]),
            r"piece 0, Line\(\[0.0\], \[1.0\], 1\), ends at \[1.0\], but piece 1, Line\(.*\), begins at \[1.001\]",
        ),
        (
            lambda: Chain([Line([0], [1], 1.0), Line([1, 1], [2, 2], 3.0)]),
            r"ends at \[1.0\], but .* at \[1.0, 1",
        ),
        (lambda: PositionTask(Polygon([[0], [1]], 1.0), gain=1.0), r"target has shape \(1,\); it must be \(2,\)"),
    ],
)
def test_refuses_paths_that_are_none(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()
