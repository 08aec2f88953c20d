"""Eq. 4.1: the closed form against derivations that share nothing with it, and the laws of mechanics."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from hqp import InvalidInput
from tasks import PlanarArm

EPS = 1e-6


@st.composite
def moving_arms(draw):
    n = draw(st.integers(1, 6))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    arm = PlanarArm(rng.uniform(0.1, 1.0, n), masses=rng.uniform(0.1, 5.0, n))
    return arm, rng.uniform(-4, 4, n), rng.uniform(-3, 3, n), rng.uniform(-5, 5, n)


many = settings(max_examples=40, deadline=None)


def slope(f, q, direction):
    """Derivative of f at q along `direction`."""
    return (f(q + EPS * direction) - f(q - EPS * direction)) / (2 * EPS)


@many
@given(moving_arms())
def test_the_mass_matrix_is_symmetric_and_positive_definite(case):
    arm, q, _, _ = case
    M = arm.mass_matrix(q)
    np.testing.assert_allclose(M, M.T, rtol=1e-12, atol=1e-12)
    assert np.linalg.eigvalsh(M)[0] > 0


@many
@given(moving_arms())
def test_the_mass_matrix_is_the_sum_over_the_links(case):
    """``M = sum m J_c^T J_c + I J_w^T J_w`` with the Jacobians of the links' middles, and I = m l^2 / 12."""
    arm, q, _, _ = case
    points, M = arm.points(q), np.zeros((arm.nv, arm.nv))
    for i in range(arm.nv):
        moved_by = np.arange(arm.nv) <= i
        reach = (points[i] + points[i + 1]) / 2 - points[:-1]
        J = np.array([-reach[:, 1], reach[:, 0], np.ones(arm.nv)]) * moved_by
        M += J.T @ np.diag(arm.masses[i] * np.array([1.0, 1.0, arm.lengths[i] ** 2 / 12])) @ J
    np.testing.assert_allclose(arm.mass_matrix(q), M, rtol=1e-10)


@many
@given(moving_arms())
def test_the_kinetic_energy_is_that_of_the_mass_points_of_the_links(case):
    """Two points a link integrate the squares of speeds exactly (Gauss and Legendre)."""
    arm, q, v, _ = case
    velocities, energy = slope(arm.points, q, v), 0.0
    for i, mass in enumerate(arm.masses):
        for share in (1 - 1 / np.sqrt(3)) / 2, (1 + 1 / np.sqrt(3)) / 2:
            velocity = (1 - share) * velocities[i] + share * velocities[i + 1]
            energy += mass / 2 * (velocity @ velocity) / 2
    assert arm.kinetic_energy(q, v) == pytest.approx(energy, rel=1e-7, abs=1e-9)
    assert arm.kinetic_energy(q, v) == pytest.approx(v @ arm.mass_matrix(q) @ v / 2, rel=1e-12)


@many
@given(moving_arms())
def test_the_coriolis_matrix_is_that_of_christoffel(case):
    arm, q, v, _ = case
    dM = np.array([slope(arm.mass_matrix, q, e) for e in np.eye(arm.nv)])  # dM[i, j, k] = dM_jk / dq_i
    symbols = (np.einsum("kij->ijk", dM) + np.einsum("jik->ijk", dM) - dM) / 2
    np.testing.assert_allclose(arm.coriolis(q, v), symbols @ v, atol=1e-6)


@many
@given(moving_arms())
def test_the_rate_of_the_mass_matrix_less_twice_the_coriolis_matrix_is_skew(case):
    arm, q, v, _ = case
    N = slope(arm.mass_matrix, q, v) - 2 * arm.coriolis(q, v)
    np.testing.assert_allclose(N, -N.T, atol=1e-6)


@many
@given(moving_arms())
def test_inverse_dynamics_is_both_matrices(case):
    arm, q, v, a = case
    tau = arm.mass_matrix(q) @ a + arm.coriolis(q, v) @ v
    np.testing.assert_allclose(arm.inverse_dynamics(q, v, a), tau, rtol=1e-10, atol=1e-10)


def test_the_torques_bring_in_the_energy():
    """The integral of ``v^T tau`` along a motion is the change of kinetic energy."""
    arm = PlanarArm([0.5, 0.4, 0.3], masses=[3.0, 2.0, 1.0])
    t, dt = np.linspace(0.0, 2.0, 20_001, retstep=True)
    rates, amplitudes = np.array([1.0, 2.3, 3.1]), np.array([1.0, -0.7, 0.5])
    phase = rates * t[:, None] + [0.0, 0.4, 0.9]
    q, v, a = amplitudes * np.sin(phase), amplitudes * rates * np.cos(phase), -amplitudes * rates**2 * np.sin(phase)
    power = np.sum(v * arm.inverse_dynamics(q, v, a), axis=-1)
    energy = arm.kinetic_energy(q, v)
    brought_in = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2) * dt])
    np.testing.assert_allclose(brought_in, energy - energy[0], atol=1e-6)
    assert np.ptp(energy) > 1.0


def test_two_links_as_in_the_textbook():
    """Siciliano et al., Robotics: Modelling, Planning and Control, section 7.3.2, without gravity and motors."""
    l1, l2, m1, m2 = 0.7, 0.4, 2.0, 3.0
    q, v, a = np.array([0.4, -1.1]), np.array([1.3, -0.8]), np.array([2.0, 5.0])
    c, s = np.cos(q[1]), np.sin(q[1])
    m12 = m2 * (l2**2 / 3 + l1 * l2 / 2 * c)
    M = [[m1 * l1**2 / 3 + m2 * (l1**2 + l2**2 / 3 + l1 * l2 * c), m12], [m12, m2 * l2**2 / 3]]
    h = m2 * l1 * l2 / 2 * s
    arm = PlanarArm([l1, l2], masses=[m1, m2])
    np.testing.assert_allclose(arm.mass_matrix(q), M, rtol=1e-13)
    np.testing.assert_allclose(arm.coriolis(q, v), [[-h * v[1], -h * v.sum()], [h * v[0], 0.0]], atol=1e-14)
    tau = M @ a + [-h * (2 * v[0] * v[1] + v[1] ** 2), h * v[0] ** 2]
    np.testing.assert_allclose(arm.inverse_dynamics(q, v, a), tau, rtol=1e-13)


def test_one_link_is_a_rod_about_its_end():
    arm = PlanarArm([0.5], masses=[6.0])
    np.testing.assert_allclose(arm.mass_matrix([1.0]), [[6.0 * 0.5**2 / 3]])
    np.testing.assert_array_equal(arm.coriolis([1.0], [3.0]), [[0.0]])
    np.testing.assert_allclose(arm.inverse_dynamics([1.0], [3.0], [2.0]), [1.0])


def test_the_mass_is_one_kilogram_a_metre_unless_given():
    np.testing.assert_array_equal(PlanarArm([0.5, 0.25]).masses, [0.5, 0.25])
    with pytest.raises(InvalidInput, match=r"mass\[1\] = -1.0 kg must be positive"):
        PlanarArm([1, 1], masses=[1.0, -1.0])


@many
@given(moving_arms())
def test_a_whole_record_at_once_is_one_after_the_other(case):
    arm, q, v, a = case
    factors = np.arange(1.0, 7.0).reshape(2, 3, 1)
    motion = q * factors, v * factors, a * factors
    for ask, takes in (
        (arm.mass_matrix, 1),
        (arm.coriolis, 2),
        (arm.kinetic_energy, 2),
        (arm.inverse_dynamics, 3),
    ):
        values = motion[:takes]
        together = ask(*values)
        for i in np.ndindex(2, 3):
            np.testing.assert_allclose(together[i], ask(*(value[i] for value in values)), rtol=1e-9, atol=1e-9)
    assert arm.inverse_dynamics(*(np.zeros((0, arm.nv)),) * 3).shape == (0, arm.nv)


@pytest.mark.parametrize(
    ("ask", "values", "named"),
    [
        ("mass_matrix", [[0, 0]], r"q has shape \(2,\); .* takes \(..., 3\), one number a joint"),
        ("mass_matrix", [0.0], r"q has shape \(\)"),
        ("coriolis", [[0, 0, 0], [0, 0]], r"v has shape \(2,\)"),
        ("kinetic_energy", [np.zeros((4, 3)), np.zeros(3)], r"v has shape \(3,\); it must be that of q, \(4, 3\)"),
        ("inverse_dynamics", [np.zeros((4, 3)), np.zeros((4, 3)), np.zeros((5, 3))], r"a has shape \(5, 3\)"),
        ("inverse_dynamics", [[0, 0, 0], [0, 0, 0], ["a", 0, 0]], "a is not an array of real numbers"),
    ],
)
def test_refuses_what_is_no_motion(ask, values, named):
    with pytest.raises(InvalidInput, match=named):
        getattr(PlanarArm([1, 1, 1]), ask)(*values)
