"""The algebra of stacks, and the hierarchy which they declare."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointMotion,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
    Stack,
)

ARM = PlanarArm([0.5, 0.4, 0.3], velocity_limit=2.0, acceleration_limit=[5.0, 6.0, 7.0])


@pytest.fixture
def parts():
    return (
        JointVelocityLimit(),
        PositionTask([0.6, 0.2], gain=2.0),
        OrientationTask(1.0, gain=3.0),
        PostureTask([0, 0, 0], gain=1.0),
    )


def test_shift_goes_down_and_plus_stays(parts):
    limit, position, orientation, posture = parts
    stack = limit >> position + orientation >> posture
    assert stack.levels == ((limit,), (position, orientation), (posture,))
    assert len(stack) == 3
    assert list(stack) == list(parts)


def test_shift_is_associative_and_the_constructor_says_the_same(parts):
    limit, position, orientation, posture = parts
    stack = limit >> position >> orientation >> posture
    assert stack == (limit >> position) >> (orientation >> posture) == limit >> (position >> (orientation >> posture))
    assert stack == Stack(limit, position, orientation, posture)
    assert stack != posture >> orientation >> position >> limit
    assert (limit + position) + orientation == limit + (position + orientation)


def test_declaring_leaves_the_operands_alone(parts):
    limit, position, orientation, posture = parts
    upper = limit >> position
    assert upper >> orientation != upper >> posture
    assert upper.levels == ((limit,), (position,))


def test_repr_reads_like_the_declaration(parts):
    limit, position, orientation, posture = parts
    assert repr(limit >> position + JointMotion(orientation) >> posture) == (
        "JointVelocityLimit() >> PositionTask([0.6, 0.2], gain=2) + JointMotion(OrientationTask([1.0], gain=3))"
        " >> PostureTask([0.0, 0.0, 0.0], gain=1)"
    )


def test_levels_are_named_after_their_parts(parts):
    limit, position, orientation, posture = parts
    rows = (limit + JointAccelerationLimit() >> position + orientation >> posture).build(ARM, "velocity", 0.01)
    assert [level.name for level in rows.hierarchy.levels] == [
        "velocity + acceleration",
        "position + orientation",
        "posture",
    ]


def test_limits_on_one_level_are_plain_bounds_and_repeat_their_joints(parts):
    stack = parts[0] + JointAccelerationLimit() >> parts[1]
    limits, rows = stack.build(ARM, "velocity", 0.01).hierarchy.levels
    assert limits.A is None
    assert limits.indices.tolist() == [0, 1, 2, 0, 1, 2]
    assert rows.A.shape == (2, 3)


def test_limits_beside_a_task_become_rows_of_the_identity(parts):
    limit, position, _, _ = parts
    rows = (position + limit).build(ARM, "velocity")
    q, v = np.array([0.3, 0.5, -0.4]), np.zeros(3)
    (level,) = rows.fill(ARM.at(q, v), 0.0).levels
    np.testing.assert_allclose(level.A, np.vstack([ARM.jacobian(q)[:2], np.eye(3)]))
    np.testing.assert_allclose(level.upper[2:], 2.0)
    np.testing.assert_allclose(level.lower[2:], -2.0)
    np.testing.assert_allclose(level.lower[:2], 2.0 * (np.array([0.6, 0.2]) - ARM.pose(q)[:2]))


def test_plain_or_dense_is_the_same_problem(parts):
    _, position, _, posture = parts
    q, v = [0.3, 0.5, -0.4], [0.0, 0.0, 0.0]
    plain = Controller(ARM, position >> posture, damping=None)(q, v)
    free = OrientationTask(1.0, gain=3.0, weight=1e-9)  # all but silent, it forces the level into dense rows
    dense = Controller(ARM, position >> posture + free, damping=None)(q, v)
    assert plain.solution.hierarchy.levels[1].A is None
    assert dense.solution.hierarchy.levels[1].A is not None
    np.testing.assert_allclose(plain.v, dense.v, atol=1e-8)


def test_filling_is_in_place_and_depends_on_the_state_only(parts):
    limit, position, orientation, posture = parts
    rows = (limit >> position >> orientation >> posture).build(ARM, "velocity", 0.01)
    rng = np.random.default_rng(3)
    first = ARM.at(*rng.uniform(-1, 1, (2, 3)))
    numbers = rows.fill(first, 0.0).copy()
    rows.fill(ARM.at(*rng.uniform(-1, 1, (2, 3))), 0.0)
    assert not np.array_equal(rows.hierarchy.A, numbers.A)
    again = rows.fill(first, 0.0)
    assert again is rows.hierarchy
    for name in ("A", "lower", "upper", "weights"):
        np.testing.assert_array_equal(getattr(again, name), getattr(numbers, name))


def test_one_stack_serves_two_robots(parts):
    limit, position, orientation, _ = parts
    stack = limit >> position >> orientation
    long = PlanarArm([0.5] * 5, velocity_limit=9.0)
    here, there = stack.build(ARM, "velocity"), stack.build(long, "velocity")
    here.fill(ARM.at(np.zeros(3), np.zeros(3)), 0.0)
    there.fill(long.at(np.zeros(5), np.zeros(5)), 0.0)
    np.testing.assert_array_equal(here.hierarchy.levels[0].upper, [2.0] * 3)
    np.testing.assert_array_equal(there.hierarchy.levels[0].upper, [9.0] * 5)


def test_a_lower_level_never_changes_a_higher_one(parts):
    _, position, orientation, posture = parts
    rng = np.random.default_rng(11)
    alone, below = (
        Controller(ARM, position >> orientation, damping=None),
        Controller(ARM, position >> orientation >> posture, damping=None),
    )
    for _ in range(10):
        q, v = rng.uniform(-2, 2, (2, 3))
        for k in range(2):
            high, low = (step.solution.levels[k].residual_norm for step in (alone(q, v), below(q, v)))
            assert low == pytest.approx(high, abs=1e-8)


@pytest.mark.parametrize(
    ("declare", "named"),
    [
        (lambda a, b: a >> 3, r"3 is a int; a stack takes tasks, limits and stacks: a >> b puts b below a"),
        (lambda a, b: a + 1.0, "1.0 is a float"),
        (lambda a, b: Stack(a, "posture"), "'posture' is a str"),
        (lambda a, b: Stack(), "an empty stack"),
        (lambda a, b: a >> b >> a, "PositionTask 'position' is in the stack twice"),
        (lambda a, b: a + a, "PositionTask 'position' is in the stack twice"),
        (lambda a, b: (a >> b) + OrientationTask(0.0, gain=1.0), r"with brackets: a >> \(b \+ c\)"),
        (lambda a, b: OrientationTask(0.0, gain=1.0) + (a >> b), "joins parts of one level"),
    ],
)
def test_refuses_what_is_no_stack(declare, named):
    with pytest.raises(InvalidInput, match=named):
        declare(PositionTask([0, 0], gain=1.0), OrientationTask(0.0, gain=1.0))
