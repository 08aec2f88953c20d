"""The flat QP adapters: optimality conditions, signs of duals, warm updates, and no stand-in for the named solver."""

from __future__ import annotations

import re
import sys
from dataclasses import Field, fields
from typing import Any

import numpy as np
import pytest
import qpsolvers

from hqp import InvalidInput, Settings
from hqp.backends.registry import BACKENDS
from hqp.qp import FlatQP, FlatResult, Sizes, make_flat_solver

FLAT = [info.qp_solver for info in BACKENDS.values() if info.qp_solver and info.installed]


def random_qp(seed: int, n: int = 5, m: int = 6, box: bool = True, rows_one_sided: bool = True) -> FlatQP:
    rng = np.random.default_rng(seed)
    R = rng.standard_normal((n, n))
    upper = np.abs(rng.standard_normal(m))
    lower = np.where(rng.random(m) < 0.5, -np.inf, -np.abs(rng.standard_normal(m))) if rows_one_sided else -upper
    width = np.where(rng.random(n) < 0.3, np.inf, 0.3)
    return FlatQP(
        R @ R.T + 0.1 * np.eye(n), 3 * rng.standard_normal(n), rng.standard_normal((m, n)), lower, upper,
        -width if box else None, width if box else None,
    )  # fmt: skip


def assert_optimal(qp: FlatQP, result: FlatResult, tolerance: float = 2e-5) -> None:
    assert result.solved, result.message
    y = result.y
    stationarity = qp.H @ y + qp.g + qp.C.T @ result.row_duals
    if qp.box_lower is not None and qp.box_upper is not None:
        stationarity += result.box_duals
        sets = [(qp.C @ y, qp.lower, qp.upper, result.row_duals), (y, qp.box_lower, qp.box_upper, result.box_duals)]
    else:
        sets = [(qp.C @ y, qp.lower, qp.upper, result.row_duals)]
    assert np.abs(stationarity).max() < tolerance
    for value, lower, upper, dual in sets:
        assert np.all(value <= upper + tolerance)
        assert np.all(value >= lower - tolerance)
        assert np.all((dual < tolerance) | (value > upper - 1e-3)), "a positive dual belongs to an upper bound"
        assert np.all((dual > -tolerance) | (value < lower + 1e-3)), "a negative dual belongs to a lower bound"


@pytest.mark.parametrize("solver", FLAT)
@pytest.mark.parametrize("box", [True, False])
def test_optimality_conditions_through_updates_and_moves(solver: str, box: bool) -> None:
    first = random_qp(0, box=box)
    flat = make_flat_solver(solver, first.sizes, Settings())
    for seed in range(5):
        qp = random_qp(seed, box=box)
        assert_optimal(qp, flat.solve(qp))
        g = qp.g + 0.5
        moved = FlatQP(qp.H, g, qp.C, qp.lower, qp.upper, qp.box_lower, qp.box_upper)
        assert_optimal(moved, flat.move(g))


@pytest.mark.parametrize("solver", FLAT)
def test_an_unconstrained_qp_is_solved_by_the_solver_itself(solver: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """qpsolvers would answer by LSQR for some of them."""

    def stand_in(problem: qpsolvers.Problem) -> None:
        raise AssertionError("LSQR stood in for the named solver")

    for name, module in list(sys.modules.items()):
        if name.startswith("qpsolvers.solvers.") and hasattr(module, "solve_unconstrained"):
            monkeypatch.setattr(module, "solve_unconstrained", stand_in)
    qp = random_qp(1, m=0, box=False)
    result = make_flat_solver(solver, qp.sizes, Settings()).solve(qp)
    assert_optimal(qp, result)
    np.testing.assert_allclose(result.y, np.linalg.solve(qp.H, -qp.g), atol=1e-4)


@pytest.mark.parametrize("solver", FLAT)
def test_an_infeasible_qp_is_an_outcome_not_an_exception(solver: str) -> None:
    qp = FlatQP(
        np.eye(2), np.zeros(2), np.array([[1.0, 0.0], [-1.0, 0.0]]), np.full(2, -np.inf), np.array([-1.0, -1.0])
    )
    settings = Settings(qp_iterations=200)
    try:
        result = make_flat_solver(solver, qp.sizes, settings).solve(qp)
    except Exception as error:
        pytest.fail(f"{type(error).__name__} escaped: {error}")
    assert not result.solved or np.abs(result.y).max() > 1e3 or not np.all(qp.C @ result.y <= qp.upper + 1e-3)
    feasible = random_qp(2, n=2, m=2, box=False, rows_one_sided=False)
    assert_optimal(feasible, make_flat_solver(solver, feasible.sizes, Settings()).solve(feasible))


def test_a_solver_that_gave_up_starts_afresh() -> None:
    for solver in ("proxsuite", "osqp"):
        flat = make_flat_solver(solver, Sizes(2, 2, False), Settings(qp_iterations=300))
        bad = FlatQP(
            np.eye(2), np.zeros(2), np.array([[1.0, 0], [-1.0, 0]]), np.full(2, -np.inf), np.array([-1.0, -1.0])
        )
        flat.solve(bad)
        good = random_qp(3, n=2, m=2, box=False)
        assert_optimal(good, flat.solve(good))


def test_settings_are_checked() -> None:
    with pytest.raises(InvalidInput, match=r"tolerance = -1\.0 must be positive and below 1"):
        Settings(tolerance=-1)
    with pytest.raises(InvalidInput, match="proximal_steps = 0 must be an integer of at least 1"):
        Settings(proximal_steps=0)
    with pytest.raises(InvalidInput, match="proximal_weight = inf must be positive and finite"):
        Settings(proximal_weight=float("inf"))


@pytest.mark.parametrize("name", ["tolerance", "rank_tolerance", "qp_tolerance", "proximal_weight"])
@pytest.mark.parametrize("value", ["a", None, [1], True, 1j, np.array([1e-9]), float("nan"), 0, 10**400])
def test_settings_take_numbers_where_numbers_are_meant(name: str, value: object) -> None:
    with pytest.raises(InvalidInput, match=f"settings: {name} = "):
        Settings(**{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("field", [field for field in fields(Settings) if field.type != "bool"], ids=lambda f: f.name)
@pytest.mark.parametrize("value", [-1, 0, -np.inf, np.nan])
def test_a_setting_that_is_refused_is_named_with_its_value_and_what_is_allowed(field: Field[Any], value: float) -> None:
    told = value if field.type == "int" else float(value)
    with pytest.raises(
        InvalidInput, match=rf"settings: {field.name} = {re.escape(str(told))} must be (positive|an int)"
    ):
        Settings(**{field.name: value})
    assert getattr(Settings(**{field.name: field.default}), field.name) == field.default


def test_only_a_time_limit_may_be_infinite() -> None:
    with pytest.raises(InvalidInput, match=r"time_limit = -1\.0 must be positive, and may be infinite"):
        Settings(time_limit=-1)
    assert Settings(time_limit=np.inf).time_limit == np.inf


@pytest.mark.parametrize("name", ["tolerance", "rank_tolerance", "qp_tolerance"])
def test_a_tolerance_is_below_one(name: str) -> None:
    with pytest.raises(InvalidInput, match=f"{name} = 1.5 must be positive and below 1"):
        Settings(**{name: 1.5})  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["a", None, 2.0, True, 10**30])
def test_settings_take_whole_numbers_where_counts_are_meant(value: object) -> None:
    for name in "qp_iterations", "proximal_steps":
        with pytest.raises(InvalidInput, match=f"settings: {name} = .* must be an integer"):
            Settings(**{name: value})  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match=r"settings: polish = 'a' must be True or False"):
        Settings(polish="a")  # type: ignore[arg-type]


def test_settings_take_numpy_numbers_and_hold_plain_ones() -> None:
    settings = Settings(qp_iterations=np.int64(5), tolerance=np.float32(0.5), polish=np.bool_(False))  # type: ignore[arg-type]
    assert settings == Settings(qp_iterations=5, tolerance=0.5, polish=False)
    assert [type(value) for value in (settings.qp_iterations, settings.tolerance, settings.polish)] == [
        int,
        float,
        bool,
    ]
