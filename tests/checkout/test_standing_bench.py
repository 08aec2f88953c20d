"""Robots that stand are played back as they were recorded, and others are given the same problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.motions.standing import WITH_TORQUES, families, standing
from benchmarks.standing.ours import OursStanding
from benchmarks.standing.scenes import DT, RAMP, SCENES, Lift, StandingScene
from benchmarks.standing.stream import StandingStream, record
from benchmarks.standing.table import UNIT_NAME, drivers, measured
from benchmarks.standing.weighted import Weighing
from hqp import Solver
from hqp.certificate import excess

pytest.importorskip("pinocchio")
LIFT = Lift("FL_foot", 0.02)


def scene(name: str) -> StandingScene:
    return next(s for s in SCENES if s.name == name)


@pytest.fixture(scope="module")
def stream() -> StandingStream:
    """A leg of a quadruped is let go, lifted, and put down."""
    return record(replace(scene("go2 steps"), ways=(), lifts=(LIFT,)), 270)


def test_contacts_change_when_they_are_told_to(stream: StandingStream) -> None:
    changing = np.flatnonzero(stream.changing)
    ramp, let_go, down = round(RAMP / DT), round(LIFT.at / DT), round(LIFT.down / DT)
    assert let_go <= changing[0] <= let_go + 1
    assert down + ramp - 1 <= changing[-1] <= down + ramp + 1
    between = np.arange(let_go + 2 * ramp + 2, down)
    assert not stream.changing[between].any()


def test_any_tick_is_played_back_as_it_was(stream: StandingStream) -> None:
    driver = OursStanding(stream)
    for k in range(len(stream) - 2, 0, -13):
        recorded = (stream.v[k + 1] - stream.v[k]) / DT
        np.testing.assert_allclose(driver.tick(k).a, recorded, atol=1e-6 * max(1.0, np.abs(recorded).max()))
        assert driver.proved(k, driver.velocity(driver.tick(k)))


def test_weighted_solvers_agree_and_keep_physics_and_limits(stream: StandingStream) -> None:
    found = [d for d in drivers(stream) if d.name.startswith("weighted")]
    assert found
    for k in 5, 60, 150:
        answers = [driver.velocity(driver.tick(k)) for driver in found]
        h = OursStanding(stream).fill(k, stream.robot.at(stream.q[k], stream.v[k]))
        above = slice(0, h.pointers[OursStanding(stream).hard])
        for x in answers:
            assert np.abs(excess(h.dense() @ x, h.lower, h.upper)[above]).max() < 1e-3
            np.testing.assert_allclose(x, answers[-1], atol=1e-2 * np.abs(answers[-1]).max())


def test_the_cost_of_a_weighted_qp_is_the_weighted_square_of_the_tasks(stream: StandingStream) -> None:
    driver = OursStanding(stream)
    h, rng = driver.fill(5, driver.state(5)), np.random.default_rng(0)
    qp = Weighing(driver.rows, driver.hard).qp()

    def cost(x: np.ndarray) -> float:
        residuals = h.weights * (h.dense() @ x - h.lower)
        own = [residuals[a:b] for a, b in zip(h.pointers, h.pointers[1:], strict=False)][driver.hard :]
        return sum(0.5 * 100.0**-k * float(r @ r) for k, r in enumerate(own))

    x, y = rng.standard_normal((2, h.n))
    difference = 0.5 * (x @ qp.H @ x - y @ qp.H @ y) + qp.g @ (x - y)
    assert difference == pytest.approx(cost(x) - cost(y), rel=1e-5)


def test_the_table_tells_of_everyone() -> None:
    at_limit, rows = measured(scene("go2 balanced"), 40, 1)
    ours, *others, unit = rows
    assert at_limit == "0.0 of 12 torques"
    assert (ours["method"], ours["proved"], ours["failed"], ours["lost"]) == ("hqp", "2/2", "0", "0e+00")
    assert (unit["method"], unit["to panda"], unit["proved"]) == (UNIT_NAME, "1", "")
    assert others
    assert all(float(row["median us"]) > 0 and row["changes us"] == "" for row in rows)


def test_ticks_are_paced(monkeypatch: pytest.MonkeyPatch, stream: StandingStream) -> None:
    from benchmarks.ticks import paced

    slept: list[float] = []
    monkeypatch.setattr(paced.time, "sleep", slept.append)
    (row,) = paced.compared([OursStanding(stream, name="one")], 45)
    assert slept == 45 * [1.0 / paced.RATE]
    assert row["method"] == "one"
    assert float(row["ratio"]) > 0


@pytest.mark.parametrize("name", families())
def test_families_of_robots_that_stand(name: str) -> None:
    played = standing(name)
    before, now = played.sample(3)
    assert before.structure == now.structure
    assert now.n == (42 if name == WITH_TORQUES else played.rows.unknowns.n)


def test_with_torques_means_the_same() -> None:
    played = standing(WITH_TORQUES)
    for draw in 0, 30, 63:
        h = played.sample(draw).now
        solution = Solver().solve(h)
        assert (len(h.levels), h.n) == (3, 42)
        assert solution.certify().ok
        a_and_f, tau = np.split(solution.x, [30])
        shared, (a, f) = played.rows.shared, np.split(a_and_f, [18])
        M, b, G = shared.blocks.mass_matrix(), shared.blocks.bias(), shared.wrenches
        np.testing.assert_allclose(tau, (M @ a + b - G.T @ f)[6:], atol=1e-6)
