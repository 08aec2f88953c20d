"""Damping by curvature as a solver: the same by every exact backend and by the interpreter, and each stage proved."""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from pathlib import Path

import curved_stacks
import numpy as np
import pytest
from curved_stacks import DT, answers, arm, stack, state
from test_interpreted import INTERPRETED

from hqp import InvalidInput, available_backends, solve
from tasks import Controller, Damped, JointLimits, OrientationTask, PlanarArm, PositionTask, PostureTask

SEEDS = range(24)
EXACT = [f"cascade:qpsolvers/{name}" for name in ("quadprog", "piqp")]


@cache
def native():
    return answers(SEEDS)


@pytest.mark.parametrize("backend", [name for name in EXACT if name in available_backends()])
def test_the_native_solver_answers_as_others_do_stage_by_stage(backend: str) -> None:
    stalled = 0
    for mine, theirs in zip(native(), answers(SEEDS, backend), strict=True):
        if not theirs.ok:
            stalled += 1
            continue
        assert theirs.solution.certify().ok
        assert [level.level for level in theirs.relaxed] == [level.level for level in mine.relaxed]
        np.testing.assert_allclose(theirs.v, mine.v, atol=1e-5)
    assert stalled <= 2  # of 72: next to nothing is left of a level, or all joints are at their bounds


def test_the_interpreter_answers_as_the_compiler_does(tmp_path: Path) -> None:
    count = 8
    command = [sys.executable, "-W", "error", curved_stacks.__file__, str(tmp_path / "v.npz"), str(count)]
    done = subprocess.run(command, env=INTERPRETED, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    theirs = np.load(tmp_path / "v.npz")
    for name, mine in zip(theirs.files, native()[: 3 * count], strict=True):
        np.testing.assert_allclose(theirs[name], mine.v, atol=1e-8)


def test_every_stage_is_proved_and_limits_hold() -> None:
    assert sum(bool(step.relaxed) for step in native()) > len(native()) // 2
    for step in native():
        assert step.ok
        certificate = step.solution.certify()
        assert certificate.ok, certificate
        assert step.solution.levels[0].residual_norm <= 1e-9


def test_every_stage_is_what_the_solver_makes_of_it_and_passes_no_bound() -> None:
    """Most are solved without it, with bounds that are met or not."""
    met = 0
    for step in native():
        for stage in step.solution.stages:
            own = stage.hierarchy.levels[0]
            values = stage.hierarchy.matrix(0) @ stage.x
            room = np.minimum(values - own.lower, own.upper - values)
            assert (room >= -1e-12).all()
            met += bool((room <= 1e-12).any())
            np.testing.assert_allclose(stage.x, solve(stage.hierarchy).x, rtol=1e-8, atol=1e-8)
    assert met > len(native()) // 4


def test_what_comes_to_rest_out_of_reach_is_proved() -> None:
    """There x is all but zero, of levels that each ask for much: their round-off must not be left in it."""
    robot = PlanarArm([0.5, 0.4, 0.3, 0.3], position_limit=(-2.6, 2.6), velocity_limit=2.0)
    tasks = PositionTask([1.8, 0.4], gain=20.0) >> OrientationTask(1.2, gain=20.0)
    controller = Controller(robot, JointLimits() >> tasks >> PostureTask(np.full(robot.nv, 0.3), gain=1.0), dt=DT)
    q, v, refused = np.full(robot.nv, 0.3), np.zeros(robot.nv), 0
    for _ in range(400):
        step = controller(q, v)
        refused += not step.solution.certify().ok
        q, v = q + DT * step.v, step.v
    assert refused <= 4  # what moves less than round-off may be refused for it
    assert np.abs(v).max() < 1e-6
    assert step.relaxed


def test_what_gave_way_is_told() -> None:
    some = 0
    for step in native():
        for level in step.relaxed:
            assert level.moved >= 0.0
            assert level.damping >= 0.0
            for soft in level.softened:
                assert np.linalg.norm(soft.direction) == pytest.approx(1.0)
                assert 0.0 <= soft.share <= 0.99
                some += 1
        assert "soft" not in str(step.solution.explain())
        assert "damping short" not in str(step.solution.explain())
    assert some


def test_what_lower_levels_moved_is_exact() -> None:
    for step in native():
        solution = step.solution
        for level in solution.relaxed:
            stage = next(own for own in solution.stages if len(own.hierarchy.levels) == level.level + 1)
            own = solution.hierarchy.levels[level.level]
            by = own.weights * (solution.hierarchy.matrix(level.level) @ (solution.x - stage.x))
            assert level.moved == pytest.approx(np.linalg.norm(by))


def stretched(*, damping="curvature", rule=None, target=(1.6, 0.3)):
    robot = PlanarArm([0.5, 0.5, 0.5], velocity_limit=2.0)
    tip = PositionTask(target, gain=2.0, name="tip")
    level = tip if rule is None else Damped(tip, rule or None)
    return Controller(robot, JointLimits() >> level >> PostureTask([0.2] * 3, gain=1.0), dt=DT, damping=damping)


def test_the_explanation_names_the_direction() -> None:
    step = stretched()([0.15, 0.08, 0.04])
    assert "tip short by" in str(step.solution.explain())
    assert "damped, the joints move it little in this direction (" in str(step.solution.explain())
    weakest = step.relaxed[0].softened[0]
    assert weakest.cause == "singular"
    assert abs(weakest.direction[0]) > 0.9  # along the arm
    assert step.solution.explain().data()["levels"][1]["damped"]


def test_without_errors_the_answer_is_the_strict_one_to_the_bit() -> None:
    q = np.array([0.3, 0.7, 0.4])
    robot = PlanarArm([0.5, 0.5, 0.5])
    tip = PositionTask(robot.at(q, np.zeros(3)).pose[:2], gain=10.0)
    for damping in "curvature", None:
        controller = Controller(robot, tip >> PostureTask(q, gain=1.0), dt=DT, damping=damping)
        step = controller(q)
        np.testing.assert_allclose(step.v, 0.0, atol=1e-12)
        assert step.relaxed == ()


def test_in_the_middle_of_the_range_the_answer_is_the_strict_one() -> None:
    robot, q = PlanarArm([0.5, 0.5, 0.5]), np.array([0.3, 0.9, 0.6])
    tip = PositionTask(robot.pose(q)[:2] + np.array([0.01, -0.02]), gain=10.0)
    default, strict = (
        Controller(robot, tip >> PostureTask(q, gain=1.0), dt=DT, damping=damping)(q) for damping in ("curvature", None)
    )
    np.testing.assert_allclose(default.v, strict.v, atol=1e-9)


def test_a_level_left_strict_and_a_rule_of_its_own() -> None:
    q = [0.15, 0.08, 0.04]
    strict = stretched(damping=None)(q)
    np.testing.assert_array_equal(stretched(damping="curvature", rule=0.1)(q).v, stretched(damping=None, rule=0.1)(q).v)
    spared = stretched(rule=False)
    assert repr(spared.stack).count("Damped(") == 1
    step = spared(q)
    assert step.solution.certify().ok
    tip = step.solution.levels[1].residual_norm
    assert tip == pytest.approx(strict.solution.levels[1].residual_norm, abs=1e-9)


@pytest.mark.parametrize("wrong", [0.1, "curved", True, ["curvature"]])
def test_a_wrong_default_is_refused_by_name(wrong: object) -> None:
    with pytest.raises(InvalidInput, match=r"damping = .*; it must be 'curvature' or None"):
        stretched(damping=wrong)


def test_strict_levels_cannot_be_joined() -> None:
    with pytest.raises(InvalidInput, match="damped as a whole"):
        Damped(PositionTask([1.0, 0.0], gain=1.0), None) + PostureTask([0.0], gain=1.0)


def test_a_stack_without_curvature_is_solved_plainly() -> None:
    robot = PlanarArm([0.5, 0.5, 0.5], velocity_limit=2.0)
    posture = PostureTask([5.0] * 3, gain=30.0)
    default, strict = (Controller(robot, JointLimits() >> posture, dt=DT, damping=d) for d in ("curvature", None))
    assert type(default._now.solver) is type(strict._now.solver)
    assert (default(np.zeros(3)).v == strict(np.zeros(3)).v).all()


def test_an_exception_below_the_loops_comes_up(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = arm(1)
    controller = Controller(robot, stack(robot, 1), dt=DT, backend="cascade:qpsolvers/quadprog")
    monkeypatch.setattr("hqp.solver.solver.Solver.solve", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        controller(*state(robot, 1))
