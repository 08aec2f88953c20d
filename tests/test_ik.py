"""Inverse kinematics: what is said of the answer is true of it, whatever the robot and the target."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    AtLeast,
    CenterOfMassTask,
    Damping,
    JointAccelerationLimit,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    ManipulabilityTask,
    OrientationTask,
    PlanarArm,
    PoseTask,
    PositionTask,
    PostureTask,
    Robot,
    Task,
    load_robot,
    solve_ik,
)
from tasks.base.rotations import from_rpy, log

ARMS = ("panda", "ur5", "kinova", "planar")


def arm(name: str) -> Any:
    if name == "planar":
        return PlanarArm([0.7, 0.5, 0.3, 0.2], position_limit=(-2.5, 2.5))
    pytest.importorskip("pinocchio")
    return load_robot(name, tip={"kinova": "j2s6s200_end_effector"}.get(name))


def tip(robot: Any, q: np.ndarray, frame: str | None = None) -> Any:
    return robot.at(q, np.zeros(robot.nv)).frame(frame)


def drawn(robot: Any, seed: int) -> np.ndarray:
    """A configuration inside the ranges."""
    rng = np.random.default_rng(seed)
    return robot.random(rng) if hasattr(robot, "random") else rng.uniform(*robot.position_limit)


def beyond(robot: Any, q: np.ndarray) -> float:
    state = robot.at(q, np.zeros(robot.nv))
    joints = getattr(state, "joints", state.q)
    low, high = robot.position_limit
    return float(np.maximum(low - joints, joints - high).max())


def stack_to(robot: Any, q: np.ndarray) -> Any:
    place = tip(robot, q)
    if robot.__class__ is PlanarArm:
        return PositionTask(place.position[:2], gain=3.0) >> OrientationTask(float(place.rotation[0]), gain=3.0)
    return PositionTask(place.position, gain=3.0) >> OrientationTask(place.rotation, gain=3.0)


@pytest.mark.parametrize("name", ARMS)
def test_what_is_in_reach_is_reached_inside_the_ranges(name: str) -> None:
    robot = arm(name)
    for seed in range(12):
        q = drawn(robot, seed)
        result = solve_ik(robot, stack_to(robot, q), seed=seed)
        assert result.reached, result
        assert result
        assert beyond(robot, result.q) <= 1e-9
        here, there = tip(robot, result.q), tip(robot, q)
        assert np.linalg.norm(here.position - there.position) <= 1e-4
        if here.rotation.ndim == 2:
            assert np.linalg.norm(log(there.rotation @ here.rotation.T)) <= 1e-3
        assert result.errors["position"]["m"] == pytest.approx(
            np.linalg.norm(here.position - there.position), abs=1e-12
        )
        assert result.iterations <= 300
        assert result.solution.certify().ok


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("restarts", [True, False])
def test_what_is_out_of_reach_ends_inside_the_ranges_and_says_why(name: str, restarts: bool) -> None:
    robot = arm(name)
    target = [2.5, 0.0] if name == "planar" else [3.0, 0.0, 0.4]
    result = solve_ik(robot, PositionTask(target, gain=1.0), restarts=restarts)
    assert not result.reached
    assert beyond(robot, result.q) <= 1e-9
    assert result.status.startswith("not reached")
    if not result.status.startswith("not reached within"):
        assert "position is out of reach, no motion of the joints brings it nearer" in result.status
    assert "position short by" in str(result.solution.explain())
    assert (result.restarts > 0) is restarts
    best = min(np.linalg.norm(tip(robot, drawn(robot, s)).position[: len(target)] - target) for s in range(200))
    assert result.errors["position"]["m"] <= best + 1e-3  # no random configuration is nearer


def test_the_limit_that_stops_a_task_is_named() -> None:
    robot = PlanarArm([1.0, 1.0], position_limit=(-0.5, 0.5))
    result = solve_ik(robot, PositionTask([0.0, 1.5], gain=1.0))
    assert not result.reached
    np.testing.assert_allclose(result.q, [0.5, 0.5], atol=1e-9)
    assert result.status.endswith(
        "position is held back by joint 0 position limit (upper), then joint 1 position limit (upper)"
    )
    assert "joint 0 position limit (upper)" in str(result.solution.explain())


def test_the_same_seed_gives_the_same_answer() -> None:
    robot = arm("panda")
    stack = stack_to(robot, drawn(robot, 3))
    first, again = (solve_ik(robot, stack, iterations=40, seed=5) for _ in range(2))
    np.testing.assert_array_equal(first.q, again.q)
    assert (first.iterations, first.restarts, first.status) == (again.iterations, again.restarts, again.status)


@pytest.mark.parametrize("iterations", [1, 2, 7, 30])
@pytest.mark.parametrize("restarts", [True, False])
def test_no_more_hierarchies_are_solved_than_allowed(iterations: int, restarts: bool) -> None:
    robot = arm("ur5")
    for target in [3.0, 0.0, 0.0], [0.3, 0.2, 0.1]:
        result = solve_ik(robot, PositionTask(target, gain=1.0), iterations=iterations, restarts=restarts)
        assert result.iterations <= iterations
        assert restarts or result.restarts == 0
        assert beyond(robot, result.q) <= 1e-9


def test_a_goal_that_is_met_at_once_takes_no_iteration() -> None:
    robot = arm("ur5")
    result = solve_ik(robot, PositionTask(tip(robot, robot.home).position, gain=1.0), settle=False)
    assert (result.reached, result.iterations) == (True, 0)
    np.testing.assert_array_equal(result.q, robot.home)
    assert result.solution.ok


def test_a_lower_level_gets_what_is_left_and_costs_the_higher_ones_nothing() -> None:
    robot = arm("panda")
    place = tip(robot, drawn(robot, 1)).position
    posture = PostureTask(robot.home, gain=1.0)
    first = solve_ik(robot, PositionTask(place, gain=1.0) >> posture, settle=False)
    settled = solve_ik(robot, PositionTask(place, gain=1.0) >> posture)
    assert first.reached
    assert settled.reached
    assert first.iterations <= settled.iterations
    assert settled.errors["posture"]["rad"] <= first.errors["posture"]["rad"] + 1e-3  # the position got more exact
    step = settled.solution.x  # nothing is left to gain
    assert np.linalg.norm(step) < 0.1


def test_higher_levels_win_where_two_contradict() -> None:
    robot = PlanarArm([1.0, 1.0])
    low, high = PositionTask([0.5, 0.5], gain=1.0, name="a"), PositionTask([-0.5, 0.5], gain=1.0, name="b")
    result = solve_ik(robot, high >> low)
    assert not result.reached
    assert result.errors["b"]["m"] <= 1e-4
    assert result.errors["a"]["m"] == pytest.approx(1.0, abs=1e-3)
    assert result.status.endswith("a is held back by b")
    assert solve_ik(robot, PositionTask([0.5, 0.5], gain=1.0) >> low, goal=low).reached


def test_both_hands_of_a_floating_base() -> None:
    pytest.importorskip("pinocchio")
    robot = load_robot("talos")
    feet, hands = ("left_sole_link", "right_sole_link"), ("gripper_left_joint", "gripper_right_joint")
    soles = [tip(robot, robot.home, name) for name in feet]
    targets = [tip(robot, robot.home, name).position + np.array([0.2, 0.0, 0.15]) for name in hands]
    left, right = (
        PoseTask(sole.position, sole.rotation, frame=name, gain=1.0, name=name)
        for name, sole in zip(feet, soles, strict=True)
    )
    reach = [PositionTask(t, frame=name, gain=1.0) for name, t in zip(hands, targets, strict=True)]
    balance = CenterOfMassTask([0.0, 0.0], gain=1.0)
    stack = left + right >> balance >> reach[0] + reach[1] >> PostureTask(robot.home, gain=1.0)
    result = solve_ik(robot, stack, settle=False)
    assert result.reached, result
    assert set(result.errors) == {*feet, "center of mass", "position", "position 2", "posture"}
    assert beyond(robot, result.q) <= 1e-9
    for name, target in zip(hands, targets, strict=True):
        assert np.linalg.norm(tip(robot, result.q, name).position - target) <= 1e-4
    for name, sole in zip(feet, soles, strict=True):
        assert np.linalg.norm(tip(robot, result.q, name).position - sole.position) <= 1e-4
    assert np.linalg.norm(result.q[3:7]) == pytest.approx(1.0)
    far = solve_ik(robot, left >> PositionTask([3.0, 0.0, 1.0], frame=hands[0], gain=1.0), iterations=40)
    assert not far.reached
    assert far.errors[feet[0]]["m"] <= 1e-4


def test_joint_limits_of_the_stack_count_as_ranges_only() -> None:
    robot = PlanarArm([1.0, 1.0, 1.0], velocity_limit=0.01, acceleration_limit=0.01)
    goal = PositionTask([1.5, 1.0], gain=0.1)
    slow = JointVelocityLimit(0.01) + JointAccelerationLimit(0.01)
    free = solve_ik(robot, goal)
    assert free.reached
    assert free.iterations < 20
    np.testing.assert_array_equal(solve_ik(robot, slow >> goal).q, free.q)
    low, high = np.full(3, -0.1), np.array([2.0, 2.0, 0.2])
    for limits in JointPositionLimit(low, high), JointLimits(JointPositionLimit(low, high), JointVelocityLimit(0.1)):
        result = solve_ik(robot, goal >> limits, q0=[-1.0, 0.0, 1.0])
        assert (result.q >= low - 1e-9).all()
        assert (result.q <= high + 1e-9).all()


def test_inequalities_and_parts_without_a_target_take_part() -> None:
    robot = arm("panda")
    hand = PositionTask([0.4, 0.2, 0.5], gain=1.0)
    elbow = AtLeast(PositionTask([0.55], frame="panda_link4", mask="z", gain=5.0, name="elbow"))
    result = solve_ik(robot, elbow >> hand >> ManipulabilityTask(PositionTask([0, 0, 0], gain=1.0), gain=1.0))
    assert result.reached
    assert tip(robot, result.q, "panda_link4").position[2] >= 0.55 - 1e-4
    assert solve_ik(robot, elbow >> hand + Damping(0.01)).reached


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"q0": [0.0]}, r"q0 has shape \(1,\); the robot takes \(3,\)"),
        ({"q0": [0.0, np.nan, 0.0]}, r"q0\[1\] = nan must be finite"),
        ({"iterations": 0}, "iterations = 0 must be an integer of at least 1"),
        ({"tolerance": 0.0}, "tolerance = 0.0 must be positive"),
        (
            {"tolerance": (1e-4, 1e-3, 1.0)},
            r"tolerance has shape \(3,\); it must be a number, or a length and an angle",
        ),
        ({"seed": -1}, "seed = -1 must be an integer of at least 0"),
        ({"restarts": 1}, "restarts = 1 must be True or False"),
        ({"goal": PositionTask([0.0, 0.0], gain=1.0)}, "is no task or inequality of the stack"),
        ({"goal": []}, "there is nothing to be met"),
        ({"backend": "nonsense"}, "unknown backend 'nonsense'"),
    ],
)
def test_wrong_input_is_refused(wrong: dict[str, Any], said: str) -> None:
    robot: Robot = PlanarArm([1.0, 1.0, 1.0])
    with pytest.raises(InvalidInput, match=said):
        solve_ik(robot, PositionTask([1.0, 1.0], gain=1.0), **wrong)


def test_a_stack_that_means_nothing_is_refused() -> None:
    robot = PlanarArm([1.0, 1.0, 1.0], position_limit=(-1.0, 1.0))
    task = PositionTask([1.0, 1.0], gain=1.0)
    with pytest.raises(InvalidInput, match="has limits only; inverse kinematics needs a task"):
        solve_ik(robot, JointVelocityLimit(1.0))
    with pytest.raises(InvalidInput, match=r"position limits of joint 0: .* from 2 to 1 rad;"):
        solve_ik(robot, JointPositionLimit(2.0, 3.0) >> task)
    with pytest.raises(InvalidInput, match="a robot has nq, nv"):
        solve_ik("panda", task)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="there is nothing to be met"):
        solve_ik(robot, Damping(1.0))


def test_other_backends_give_the_same() -> None:
    robot = PlanarArm([0.7, 0.7, 0.3], position_limit=(-2.0, 2.0))
    stack = PositionTask([1.0, 0.4], gain=1.0) >> OrientationTask(0.3, gain=1.0)
    answers = [solve_ik(robot, stack, backend=name) for name in ("native", "cascade:proxsuite")]
    assert all(answer.reached for answer in answers)
    np.testing.assert_allclose(answers[0].q, answers[1].q, atol=1e-5)


def test_a_rotation_of_half_a_turn_is_found() -> None:
    robot = arm("ur5")
    R = from_rpy(np.pi, 0.0, 0.0) @ tip(robot, robot.home).rotation
    assert solve_ik(robot, OrientationTask(R, gain=1.0)).reached


def test_numbers_that_mean_nothing_are_a_status() -> None:
    class Broken(Task):
        rows = 1

        def error(self, state: Any, t: float) -> np.ndarray:
            return np.array([1.0 if not state.q.any() else np.nan])

        def jacobian(self, state: Any) -> np.ndarray:
            return np.ones((1, 2))

    result = solve_ik(PlanarArm([1.0, 1.0]), Broken(gain=1.0))
    assert not result.reached
    assert np.isfinite(result.q).all()
    assert solve_ik(PlanarArm([1.0, 1.0]), Broken(gain=1.0), q0=[1.0, 1.0]).status.startswith("stopped, invalid: ")
