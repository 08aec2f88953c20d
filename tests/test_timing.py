"""Timing laws: from rest to rest, derivatives against finite differences, and the thesis's own formula."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from hqp import InvalidInput
from tasks import Line, cubic, cycloid, harmonic, quintic
from tasks.targets.timing import as_timing

LAWS = [cubic, quintic, harmonic, cycloid]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
inside = st.floats(0.001, 0.999)


@every_law
@given(inside)
def test_the_derivatives_are_those_of_the_law(law, u):
    h = 1e-5
    before, (_, rate, bend), after = law(u - h), law(u), law(u + h)
    assert rate == pytest.approx((after[0] - before[0]) / (2 * h), abs=1e-7)
    assert bend == pytest.approx((after[1] - before[1]) / (2 * h), abs=1e-7)


@every_law
@given(inside)
def test_the_way_back_is_the_way_there(law, u):
    s, rate, bend = law(u)
    back = law(1 - u)
    assert (1 - back[0], back[1], -back[2]) == pytest.approx((s, rate, bend), abs=1e-12)


@every_law
@given(st.floats(0, 1), st.floats(0, 1))
def test_a_law_only_goes_forward(law, u, w):
    assert law(min(u, w))[0] <= law(max(u, w))[0] + 1e-15
    assert -1e-15 <= law(u)[0] <= 1.0 + 1e-15
    assert law(u)[1] >= 0.0


@every_law
def test_at_rest_before_the_start_and_from_the_end_on(law):
    for u in (-np.inf, -7.0, -1e-300):
        assert law(u) == (0.0, 0.0, 0.0)
    for u in (1.0, 7.0, np.inf):
        assert law(u) == (1.0, 0.0, 0.0)
    assert law(0.0)[:2] == (0.0, 0.0)
    assert law(1 - 1e-12)[:2] == pytest.approx((1.0, 0.0), abs=1e-10)


@pytest.mark.parametrize("law", [quintic, cycloid])
def test_quintic_and_cycloid_have_no_acceleration_at_the_ends(law):
    assert law(0.0)[2] == 0.0
    assert law(1 - 1e-12)[2] == pytest.approx(0.0, abs=1e-9)


@every_law
def test_no_time_is_no_place(law):
    """NaN must not pass for the end of the path."""
    assert np.isnan(law(np.nan)).all()


@given(st.floats(0, 1, exclude_max=True))
def test_the_laws_are_their_formulas(u):
    assert cubic(u) == pytest.approx((3 * u**2 - 2 * u**3, 6 * u - 6 * u**2, 6 - 12 * u), abs=1e-14)  # Eq. 3.26
    assert quintic(u)[0] == pytest.approx(10 * u**3 - 15 * u**4 + 6 * u**5, abs=1e-14)
    assert harmonic(u)[0] == pytest.approx((1 - np.cos(np.pi * u)) / 2, abs=1e-14)
    assert cycloid(u)[0] == pytest.approx(u - np.sin(2 * np.pi * u) / (2 * np.pi), abs=1e-14)


def test_a_law_of_your_own():
    def linear(u):
        return (min(max(u, 0.0), 1.0), float(0.0 <= u < 1.0), 0.0)

    assert as_timing(cubic, "timing") is cubic
    assert as_timing(linear, "timing")(0.25) == linear(0.25)  # watched, see test_functions_of_time.py
    np.testing.assert_array_equal(Line([0.0], [4.0], 2.0, timing=linear)(0.5), [[1.0], [2.0], [0.0]])


@pytest.mark.parametrize(
    ("law", "named"),
    [
        (3, "timing = 3 is a int; it must be a function"),
        (lambda: 0.0, r"timing\(-1.0\) raised TypeError"),
        (lambda u: u, r"timing\(-1.0\) = -1.0 must be \(s, ds/du, d2s/du2\)"),
        (lambda u: (u, 1.0, 0.0), r"timing\(-1.0\) = \[-1.0, 1.0, 0.0\] must be .* at rest: \(0.0, 0.0, 0.0\)"),
        (lambda u: (max(u, 0.0), float(u > 0), 0.0), r"timing\(2.0\) = \[2.0, 1.0, 0.0\] must be .* at rest: \(1.0,"),
        (lambda u: (np.nan, 0.0, 0.0), r"timing\(-1.0\) = \[nan, 0.0, 0.0\]"),
        (lambda u: "abc", r"timing\(-1.0\) is not an array of real"),
    ],
)
def test_refuses_laws_that_are_none(law, named):
    with pytest.raises(InvalidInput, match=named):
        as_timing(law, "timing")
