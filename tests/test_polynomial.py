"""Polynomials meet their conditions (Eq. 3.20), and those of a timing law give the timing law."""

from __future__ import annotations

import doctest
from math import factorial

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

import tasks.targets.polynomial
from hqp import InvalidInput
from tasks import Polynomial, Trajectory, cubic, quintic


@st.composite
def polynomials(draw, most=5, most_via=2):
    """Random conditions of orders up to `most` at the ends and at times between, each about as large as the way."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    rows, duration = draw(st.integers(1, 3)), 10.0 ** draw(st.integers(-2, 3))
    size = 10.0 ** draw(st.integers(-3, 3))

    def conditions(count):
        scale = np.array([factorial(d) / duration**d for d in range(count)])
        return size * scale[:, None] * rng.uniform(-1, 1, (count, rows))

    start, end = conditions(draw(st.integers(1, most))), conditions(draw(st.integers(1, most)))
    counts = draw(st.lists(st.integers(1, 3), max_size=most_via))
    times = duration * (np.arange(1, len(counts) + 1) / (len(counts) + 1) + rng.uniform(-0.1, 0.1, len(counts)))
    via = {float(t): conditions(count) for t, count in zip(times, counts, strict=True)}
    return Polynomial(start, end, duration, via=via), size


def derivative(polynomial, order, t):
    """From the coefficients of Eq. 3.19, scaled by T^d / d! to the size of a position."""
    a = polynomial.coefficients
    rise = np.array([factorial(i) // factorial(i - order) if i >= order else 0 for i in range(len(a))])
    return (rise * t ** np.maximum(np.arange(len(a)) - order, 0)) @ a * polynomial.duration**order / factorial(order)


@given(polynomials())
def test_every_condition_is_met(case):
    polynomial, size = case
    T = polynomial.duration
    given = {0.0: polynomial.start, T: polynomial.end, **polynomial.via}
    for t, conditions in given.items():
        tolerance = 1e-10 if t in polynomial.via else 1e-12  # between, large swings may have to cancel
        for order, (value, asked) in enumerate(zip(polynomial(t), conditions, strict=False)):
            scale = T**order / factorial(order)
            np.testing.assert_allclose(scale * value, scale * asked, rtol=0.0, atol=tolerance * size)


@pytest.mark.parametrize(("k", "m"), [(2, 2), (3, 3), (5, 5), (5, 1), (1, 5), (8, 8)])
@pytest.mark.parametrize("duration", [0.01, 1.0, 60.0])
def test_from_rest_to_rest_at_any_degree(k, m, duration):
    start, end = np.zeros((k, 2)), np.zeros((m, 2))
    start[0], end[0] = [1.0, 0.0], [1.0, 1.0]  # the ends of Eq. 3.21
    polynomial = Polynomial(start, end, duration)
    for t, conditions in (0.0, start), (duration, end):
        for order, (value, asked) in enumerate(zip(polynomial(t), conditions, strict=False)):
            np.testing.assert_allclose(duration**order * value, duration**order * asked, rtol=1e-12, atol=1e-12)


@given(polynomials(most_via=0))
def test_the_coefficients_have_the_conditions_of_all_orders(case):
    """Jerk and beyond, which a call does not give. At the end the powers of t lose some digits."""
    polynomial, size = case
    T = polynomial.duration
    for t, conditions, tolerance in (0.0, polynomial.start, 1e-12), (T, polynomial.end, 1e-9):
        for order, asked in enumerate(conditions):
            scaled = asked * T**order / factorial(order)
            np.testing.assert_allclose(derivative(polynomial, order, t), scaled, rtol=0.0, atol=tolerance * size)


@given(polynomials(), st.floats(0, 1))
def test_the_motion_is_the_polynomial_of_its_coefficients(case, u):
    polynomial, size = case
    T = polynomial.duration
    largest = np.abs(polynomial.coefficients * (T ** np.arange(polynomial.degree + 1.0))[:, None]).max() + size
    for order, value in enumerate(polynomial(u * T)):
        scaled = value * T**order / factorial(order)
        tolerance = 1e-12 * largest * (polynomial.degree + 1) ** order
        np.testing.assert_allclose(derivative(polynomial, order, u * T), scaled, rtol=0.0, atol=tolerance)


@given(polynomials(most=3, most_via=1), st.floats(0.01, 0.99))
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(case, u):
    polynomial, size = case
    T, h = polynomial.duration, 1e-5
    before, (_, velocity, acceleration), after = (polynomial((u + step) * T) for step in (-h, 0.0, h))
    largest = np.abs(polynomial.coefficients * (T ** np.arange(polynomial.degree + 1.0))[:, None]).max() + size
    difference = [(b - a) / (2 * h) for a, b in zip(before, after, strict=True)]
    np.testing.assert_allclose(T * velocity, difference[0], rtol=0.0, atol=1e-6 * largest)
    np.testing.assert_allclose(T**2 * acceleration, T * difference[1], rtol=0.0, atol=1e-5 * largest)


@given(polynomials())
def test_the_degree_is_one_less_than_the_conditions(case):
    polynomial, _ = case
    conditions = len(polynomial.start) + len(polynomial.end) + sum(map(len, polynomial.via.values()))
    assert polynomial.degree == conditions - 1
    assert polynomial.coefficients.shape == (conditions, polynomial.start.shape[1])


@pytest.mark.parametrize(("law", "count"), [(cubic, 2), (quintic, 3)])
@given(st.floats(0, 1, exclude_max=True))
def test_cubic_and_quintic_are_the_polynomials_of_their_conditions(law, count, u):
    rest = [0.0] * (count - 1)
    parts = Polynomial([0.0, *rest], [1.0, *rest], 1.0)(u)
    np.testing.assert_allclose(np.ravel(parts), law(u), rtol=0.0, atol=2e-14)


def test_the_coefficients_of_eq_3_26():
    path = Polynomial([[1.0, 0.0], [0.0, 0.0]], [[1.0, 1.0], [0.0, 0.0]], 1.0)
    np.testing.assert_array_equal(path.coefficients.T, [[1, 0, 0, 0], [0, 0, 3, -2]])
    assert isinstance(path, Trajectory)


@given(polynomials(most=3, most_via=2), st.floats(0, 1))
def test_conditions_which_hold_already_change_nothing(case, u):
    polynomial, size = case
    T = polynomial.duration
    if any(abs(t / T - 0.45) < 0.02 for t in polynomial.via):
        return
    more = Polynomial(
        polynomial.start, polynomial.end, T, via={**polynomial.via, 0.45 * T: np.array(polynomial(0.45 * T))}
    )
    largest = np.abs(polynomial.coefficients * (T ** np.arange(polynomial.degree + 1.0))[:, None]).max() + size
    np.testing.assert_allclose(more(u * T)[0], polynomial(u * T)[0], rtol=0.0, atol=1e-9 * largest)


def test_the_order_of_the_times_in_via_does_not_matter():
    there, back = {0.5: [2.0, 0.0], 1.5: [1.0]}, {1.5: [1.0], 0.5: [2.0, 0.0]}
    a, b = (Polynomial([0.0], [3.0], 2.0, via=via) for via in (there, back))
    np.testing.assert_array_equal(a.coefficients, b.coefficients)


@given(polynomials())
def test_outside_it_holds_its_ends_at_rest(case):
    polynomial, _ = case
    T = polynomial.duration
    for t, place in (-T, polynomial.start[0]), (-np.inf, polynomial.start[0]), (2 * T, polynomial.end[0]):
        position, velocity, acceleration = polynomial(t)
        np.testing.assert_array_equal(position, place)
        assert not velocity.any()
        assert not acceleration.any()


@given(polynomials())
def test_no_time_is_no_place(case):
    assert all(np.isnan(part).all() for part in case[0](np.nan))


def test_one_row_needs_no_second_axis():
    short = Polynomial([1.0, 0.5], [2.0], 3.0, via={1.0: 1.2})
    long = Polynomial([[1.0], [0.5]], [[2.0]], 3.0, via={1.0: [[1.2]]})
    np.testing.assert_array_equal(short(2.0), long(2.0))
    assert repr(short) == repr(long) == "Polynomial([[1.0], [0.5]], [[2.0]], 3, via={1.0: [[1.2]]})"


def test_the_examples_of_the_module_are_true():
    assert doctest.testmod(tasks.targets.polynomial) == (0, 2)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Polynomial([0, 0], [1, 0], 0.0), "polynomial: duration = 0.0 s must be positive"),
        (lambda: Polynomial([0, np.nan], [1, 0], 1.0), r"polynomial: start\[1\] = nan must be finite"),
        (lambda: Polynomial([], [1, 0], 1.0), r"start has shape \(0,\); it must be \(conditions, rows\)"),
        (lambda: Polynomial([0], np.zeros((1, 1, 1)), 1.0), r"end has shape \(1, 1, 1\); it must be"),
        (lambda: Polynomial([0, 0], [[1, 0]], 1.0), "conditions at t = 1 s have 2 rows, at 0 s 1; they must"),
        (lambda: Polynomial([0], [1], 1.0, via=[0.5]), r"polynomial: via = \[0.5\] is a list; it must be a dict"),
        (lambda: Polynomial([0], [1], 1.0, via={1.0: [0.5]}), "time in via = 1.0 s must be between 0 and the duration"),
        (lambda: Polynomial([0], [1], 1.0, via={"a": [0.5]}), "polynomial: time in via"),
        (lambda: Polynomial([0], [1], 1.0, via={0.5: [np.inf]}), r"polynomial: via\[0.5\]\[0\] = inf must be finite"),
        (lambda: Polynomial([0], [1], 1.0, via={0.5: [[0, 1]]}), "conditions at t = 0.5 s have 2 rows"),
        (lambda: Polynomial([0], [1], 3.0, via={5e-324: 1, 1e-323: 2}), r"s must be further apart"),
        (
            lambda: Polynomial([0], [1], 1.0, via={1e-320: 1}),
            "coefficients leave the range of floats; of degree 2 over",
        ),
        (
            lambda: Polynomial([0], [1], 1.0, via={k / 40: [k % 2, 0, 0] for k in range(1, 40)}),
            "of degree 118 it is too steep to meet the conditions at t = .* split into a chain",
        ),
        (lambda: Polynomial([0, 1e300], [1], 1e15), r"start\[1\] = 1e\+300 must be at most 1e\+15 in size"),
    ],
)
def test_refuses_conditions_that_are_none(make, named):
    with pytest.raises(InvalidInput, match=named):
        make()
