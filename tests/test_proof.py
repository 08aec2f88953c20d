"""A proof is one of the hierarchy that was given: whoever reads one of its numbers wrong gets none.

Every way from a given hierarchy to what is solved is taken, with one row, bound or weight overwritten after all are
written: strict, by every kind of backend; damped by rules, at once and stage by stage; softened, stage by stage. Either
the answer is the right one all the same, or ``certify`` refuses it.
"""

from __future__ import annotations

from collections import Counter
from functools import cache

import curved_stacks
import numpy as np
import pytest
from contact_scenes import humanoid
from misread import Misreader, Slip, in_python, misread, slips, stage_misread

import hqp
from hqp import FixedDamping, Hierarchy, InvalidInput, Level, NumericalFiltering, SingularValueDamping, Solver
from hqp.certificate import Handed, left_alone
from tasks import (
    CenterOfMassTask,
    Controller,
    JointLimits,
    JointTorqueLimit,
    OrientationTask,
    PositionTask,
    PostureTask,
    load_robot,
)

#: From so much on, relative to x, an answer is another one.
OTHER = 1e-7


def distance(x, y):
    return float(np.linalg.norm(x - y)) / (1.0 + float(np.linalg.norm(y)))


# Softened stacks.


def planar(seed):
    robot = curved_stacks.arm(seed)
    return Controller(robot, curved_stacks.stack(robot, seed), dt=curved_stacks.DT), curved_stacks.state(robot, seed)


@cache
def panda():
    """Torque limits that hold, and a target out of reach."""
    robot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=np.full(7, 20.0))
    limits = JointTorqueLimit(30.0) + JointLimits()
    place = PositionTask([1.2, 0.2, 0.4], gain=6.0, frame="panda_hand")
    stack = (
        limits >> place >> OrientationTask(np.eye(3), gain=6.0, frame="panda_hand") >> PostureTask(robot.home, gain=2.0)
    )
    controller = Controller(robot, stack, order="acceleration", dt=2e-3)
    return controller, (np.array([0.1, 0.3, -0.1, -0.4, 0.1, 0.8, 0.2]), np.full(7, 0.1))


@cache
def standing():
    """A humanoid on both feet that is to shift its weight too far, at velocity order."""
    scene = humanoid()
    left, right = scene.feet
    far = CenterOfMassTask(scene.com + np.array([0.5, 0.0, 0.4]), gain=5.0)
    stack = JointLimits() >> left + right >> far >> OrientationTask(scene.up, frame="pelvis", gain=8.0)
    controller = Controller(scene.robot, stack >> PostureTask(scene.q, gain=4.0), dt=2e-3)
    return controller, (scene.q, scene.v)


def judge(controller, state, seed, count, told):
    """Slips in every stage: how many were refused, and how many changed nothing."""
    in_python(controller)
    right = controller(*state).solution
    assert right.ok
    assert right.certify().ok, right.certify()
    rng = np.random.default_rng(seed)
    for stage in right.stages if right.staged is not None else ():
        k = len(stage.hierarchy.levels) - 1
        for slip in slips(stage.hierarchy, rng, count):
            other = stage_misread(controller, state, k, slip)
            if not other.ok or other.staged is None:
                continue
            certified, away = other.certify().ok, distance(other.staged.reached[k], right.staged.reached[k])
            assert not certified or away <= OTHER, f"level {k}, {slip}: certified, and off by {away:g}"
            told["refused" if not certified else "right all the same"] += 1


def test_a_stage_that_was_misread_is_refused():
    told = Counter()
    for seed in range(12):
        judge(*planar(seed), seed, 2, told)
    assert told["refused"] > 50, told


@pytest.mark.parametrize("scene", [panda, standing])
def test_so_it_is_on_robots(scene):
    told = Counter()
    judge(*scene(), 0, 4, told)
    assert told["refused"] > 10, told


@pytest.mark.sweep
def test_no_stage_is_misread_on_many_arms():
    told = Counter()
    for seed in range(12, 150):
        judge(*planar(seed), seed, 4, told)
    print(told)


def test_torque_limits_that_are_overwritten_in_a_stage_are_missed():
    """One entry of their rows after the other, in the last stage: what then breaks a limit is not certified."""
    controller, state = panda()
    in_python(controller)
    last = controller(*state).solution.stages[-1].hierarchy
    k, broken = len(last.levels) - 1, 0
    for place in range(7 * last.n):
        other = stage_misread(controller, state, k, Slip(place, -1.0))
        if other.ok and other.levels[0].residual_norm > 1e-6:
            broken += 1
            assert not other.certify().ok
    assert broken


def test_what_is_handed_over_is_to_stay():
    rows, x = np.array([[1.0, 0.0], [0.0, 2.0]]), np.array([1.0, 1.0])
    handed = Handed(3, rows, 2.0, x)
    assert left_alone(handed, "tip", x + 1e-12, 1e-9).ok
    moved = left_alone(handed, "tip", x + np.array([1e-3, 0.0]), 1e-9)
    assert (moved.ok, moved.level, moved.name) == (False, 3, "tip, handed over")
    assert moved.residual_norm == pytest.approx(1e-3)


def test_levels_below_may_move_only_what_is_declared_soft():
    controller, state = planar(0)
    solution = controller(*state).solution
    certificate = solution.certify()
    assert certificate.ok
    assert certificate.softened
    assert str(certificate).startswith("certified, on the rows that were given: strict: level 0 (joint limits)")
    assert certificate.handed
    # The x of the last stage alone: proved there, and not what the levels above had left.
    held = max(solution.staged.handed, key=lambda handed: np.abs(handed.rows).max())
    direction = np.linalg.svd(held.rows)[2][0]
    wrong = left_alone(held, "", solution.x + 1e-4 * direction, 1e-9)
    assert not wrong.ok


# Strict hierarchies, by every kind of backend, and levels damped by rules.


def strict(rng, inequalities=True):
    """Bounds, rows with bounds and without, and weights."""
    n = int(rng.integers(3, 8))
    levels = [Level.bounds(-rng.uniform(0.2, 1.0, n), rng.uniform(0.2, 1.0, n))] if inequalities else []
    for k in range(3):
        A, b = rng.standard_normal((2, n)), rng.standard_normal(2)
        width = np.array([0.0, 0.3 * (k % 2) * inequalities])
        levels.append(Level(A, b - width, b + width, weights=rng.uniform(0.5, 2.0, 2), name=f"task {k}"))
    return Hierarchy(levels)


KINDS = [name for name in ("native", "cascade:qpsolvers/quadprog", "pseudoinverse") if name in hqp.available_backends()]


@pytest.mark.parametrize("backend", KINDS)
@pytest.mark.parametrize("lasting", [False, True])
def test_a_hierarchy_that_was_misread_is_refused(backend, lasting):
    """Also where the number stays overwritten in the arrays of the caller."""
    refused = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        h = strict(rng, inequalities=hqp.backend_info(backend).inequalities)
        x_ref = rng.standard_normal(h.n)
        right = hqp.solve(h, backend=backend, x_ref=x_ref)
        assert right.certify().ok
        for slip in slips(h, rng, 2):
            other = misread(Solver(backend), h.copy(), slip, x_ref, lasting)
            if not other.ok:
                continue
            np.testing.assert_array_equal(other.hierarchy.numbers, h.numbers)
            certified = other.certify().ok
            assert not certified or distance(other.x, right.x) <= OTHER
            refused += not certified
    assert refused > 10


RULES = (FixedDamping(0.3), SingularValueDamping(0.3, 2.0), NumericalFiltering(0.1, 0.3, 2.0))


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: type(rule).__name__)
@pytest.mark.parametrize("lasting", [False, True])
def test_a_damped_level_that_was_misread_is_refused(rule, lasting):
    """By the native solver, all at once, with the lambda that it declares; numerical filtering goes stage by stage."""
    refused = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        h, at_once = strict(rng), not isinstance(rule, NumericalFiltering)
        x_ref, damping = rng.standard_normal(h.n), {1: rule}
        assert hqp.solve(h, damping=damping, x_ref=x_ref).certify().ok
        for slip in slips(h, rng, 2):
            try:
                other = misread(Solver(damping=damping), h.copy(), slip, x_ref, lasting)
            except InvalidInput:  # filtering takes no inequality, which the slip has made
                continue
            if not other.ok:
                continue
            certified, declared = other.certify().ok, other.dampings.get(1, 0.0)
            right = hqp.solve(h, damping=({1: declared} if declared else None) if at_once else damping, x_ref=x_ref)
            assert not certified or distance(other.x, right.x) <= OTHER
            refused += not certified
    assert refused > 10 or not (
        at_once or lasting
    )  # a stage of its own has read the numbers when these are right again


def test_one_stage_of_a_damped_level_that_was_misread_is_refused():
    """Stage by stage, in the rows of damping, too."""
    refused = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        h = strict(rng)
        right = hqp.solve(h, damping={1: RULES[2]})
        assert right.certify().ok
        for stage in right.stages:
            key = len(stage.hierarchy.levels) - 1, False
            for slip in slips(stage.hierarchy, rng, 2):
                solver = Solver(damping={1: RULES[2]})
                solver.solve(h)
                at = key if key in solver._staged._stages else (len(h.levels), False)
                solver._staged._stages[at] = Misreader(Solver().solve, slip)
                try:
                    other = solver.solve(h)
                except (IndexError, InvalidInput):  # beyond a smaller stage; or none that filtering takes
                    continue
                if not other.ok:
                    continue
                certified = other.certify().ok
                assert not certified or distance(other.x, right.x) <= OTHER
                refused += not certified
    assert refused > 10


def test_another_reference_or_aim_is_refused():
    rng = np.random.default_rng(0)
    tasks = Level.equality(rng.standard_normal((2, 6)), [0.3, 0.2])
    h = Hierarchy([Level.bounds([-9.0] * 6, [9.0] * 6), tasks, Level.equality(rng.standard_normal((1, 6)), [0.1])])
    for damping in {}, {1: 0.3}:
        x_ref = rng.standard_normal(h.n)
        aims = {1: rng.standard_normal(h.n)} if damping else None
        right = hqp.solve(h, damping=damping, x_ref=x_ref, aims=aims)
        assert right.certify().ok
        solver = Solver(damping=damping)
        solver.solve(h, x_ref, aims)
        refer = solver._way.refer
        solver._way.refer = lambda reference, own, refer=refer: refer(reference + 0.5, own)
        assert not solver.solve(h, x_ref, aims).certify().ok
        if damping:
            solver._way.refer = lambda reference, own, refer=refer: refer(reference, own + 0.5)
            assert not solver.solve(h, x_ref, aims).certify().ok
