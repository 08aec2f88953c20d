"""What inverse kinematics keeps between calls: no answer is another for it, nothing set is missed, nothing leaks."""

from __future__ import annotations

import copy
import gc
import pickle
import threading
import weakref
from typing import Any

import numpy as np
import pytest
from live_table import GROUPS, SETTINGS, Made
from live_work import Alive, as_it_is, subclassed

from hqp import InvalidInput
from tasks import (
    AtLeast,
    CenterOfMassTask,
    JointPositionLimit,
    OrientationTask,
    PlanarArm,
    PoseTask,
    PositionTask,
    PostureTask,
    Setpoint,
    Within,
    load_robot,
    solve_ik,
)
from tasks.ik import pool

NAMES = ("planar", "panda", "g1")


def robot_of(name: str) -> Any:
    if name == "planar":
        return PlanarArm([0.7, 0.5, 0.3, 0.2], position_limit=(-2.5, 2.5))
    pytest.importorskip("pinocchio")
    return load_robot(name, tip="right_wrist_yaw_link" if name == "g1" else None)


def told(robot: Any, stack: Any, **options: Any) -> tuple[Any, ...]:
    """All of an answer, or of a refusal."""
    try:
        found = solve_ik(robot, stack, **options)
    except InvalidInput as refusal:
        return (str(refusal),)
    x, numbers = found.solution.x.tobytes(), found.solution.hierarchy.numbers.tobytes()
    return found.q.tobytes(), found.status, str(found.errors), found.iterations, found.restarts, x, numbers


def kept(robot: Any) -> int:
    """How many problems a robot keeps for this thread."""
    return len(pool._kept(robot))


def stacks(robot: Any, seed: int, *, flat: bool) -> list[Any]:
    """Stacks of several forms, with targets drawn at random."""
    rng = np.random.default_rng(seed)
    low, high = np.maximum(robot.position_limit, -3.0)[0], np.minimum(robot.position_limit, 3.0)[1]
    q = robot.random(rng) if hasattr(robot, "random") else rng.uniform(low, high)
    tip = robot.at(q, np.zeros(robot.nv)).frame()
    p = tip.position[:2] if flat else tip.position
    place = PositionTask(p, gain=1.0 + seed)
    turn = OrientationTask(float(tip.rotation[0]) if flat else tip.rotation, gain=2.0)
    high_up = AtLeast(PositionTask([float(p[1]) - 0.1], mask="y", gain=1.0))
    found = [place, place >> turn, place + turn >> PostureTask(q, gain=1.0), high_up >> turn, Within(place, 0.02)]
    return found if flat else [*found, PoseTask(tip.position, tip.rotation, gain=1.0), CenterOfMassTask(p, gain=1.0)]


@pytest.mark.parametrize("name", NAMES)
def test_a_kept_problem_answers_as_a_new_one_to_the_last_bit(name: str) -> None:
    used, flat = robot_of(name), name == "planar"
    forms = len(stacks(used, 0, flat=flat))
    for seed in range(3):
        new = copy.deepcopy(used)  # copies take along nothing of what is kept
        for mine, theirs in zip(stacks(used, seed, flat=flat), stacks(new, seed, flat=flat), strict=True):
            assert told(used, mine, iterations=25) == told(new, theirs, iterations=25)
        assert kept(used) == forms  # each form is planned once


@pytest.mark.parametrize("robot", SETTINGS)
@pytest.mark.parametrize("group", GROUPS)
def test_what_is_set_between_calls_is_seen(group: str, robot: str) -> None:
    """Every attribute of every part that may be set, there and back, gives what a robot gives that has kept nothing."""
    setting, wrong, options = SETTINGS[robot](), list[str](), {"iterations": 3, "restarts": False}
    used = copy.deepcopy(setting.robot)
    for case in GROUPS[group](setting):
        for path, change in (case.live | case.either).items():
            value = change.value if isinstance(change, Made) else change
            for wrap in (as_it_is, subclassed) if path.endswith("target") else (as_it_is,):
                alive = Alive(case, setting, wrap)
                old, first = alive.get(path), told(used, alive.stack, q0=setting.q, **options)
                try:
                    alive.set(path, value)
                except InvalidInput:
                    continue
                expected = told(copy.deepcopy(setting.robot), alive.stack, q0=setting.q, **options)
                if told(used, alive.stack, q0=setting.q, **options) != expected:
                    wrong.append(f"{case.spec.kind.__name__}.{path}")
                alive.set(path, old)
                if told(used, alive.stack, q0=setting.q, **options) != first:
                    wrong.append(f"{case.spec.kind.__name__}.{path}, set back")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", NAMES[:2])
def test_limits_goals_and_tolerances_are_those_of_the_call(name: str) -> None:
    robot = robot_of(name)
    flat = name == "planar"
    place, turn = stacks(robot, 4, flat=flat)[1]
    low, high = robot.position_limit

    def same(**options: Any) -> None:
        ranges = JointPositionLimit(low * 0.9, high * 0.9)
        for stack in place >> turn, ranges >> place >> turn:
            new = copy.deepcopy(robot)
            assert told(robot, stack, iterations=20, **options) == told(new, stack, iterations=20, **options)

    same()
    same(goal=place)
    same(goal=(place, turn))
    same(goal=turn, tolerance=(1e-2, 1e-6))
    same(backend="cascade")
    same(goal=PositionTask([0.1] * (2 if flat else 3), gain=1.0))  # refused
    robot.position_limit = 0.5 * low, 0.5 * high
    same()
    ranges = JointPositionLimit(low * 0.4, high * 0.4)
    stack = ranges >> place >> turn
    wide = solve_ik(robot, stack, iterations=20)
    ranges.lower, ranges.upper = low * 0.1, high * 0.1
    assert told(robot, stack, iterations=20) == told(copy.deepcopy(robot), stack, iterations=20)
    assert (np.abs(solve_ik(robot, stack, iterations=20).q) <= 0.1 * np.maximum(high, -low) + 1e-9).all()
    assert (np.abs(wide.q) > 0.1 * np.maximum(high, -low)).any()


def test_targets_that_move_are_where_they_are_now() -> None:
    robot = robot_of("planar")
    hand = Setpoint([0.9, 0.4])
    task = PositionTask(hand, gain=1.0)
    for goal in [0.9, 0.4], [0.3, 0.8]:
        hand.move(goal)
        np.testing.assert_allclose(robot.pose(solve_ik(robot, task).q)[:2], goal, atol=1e-4)


def test_earlier_answers_stay_as_they_are() -> None:
    robot = PlanarArm([1.0, 1.0], position_limit=(-0.5, 0.5))
    first = solve_ik(robot, PositionTask([0.0, 1.5], gain=1.0))
    untouched = solve_ik(copy.deepcopy(robot), PositionTask([0.0, 1.5], gain=1.0))
    for x in 0.2, 0.4, 1.9:
        solve_ik(robot, PositionTask([x, 0.3], gain=1.0))
    assert str(first.solution.explain()) == str(untouched.solution.explain())
    assert str(pickle.loads(pickle.dumps(first)).solution.explain()) == str(untouched.solution.explain())
    assert first.solution.certify().ok
    assert first.q.tobytes() == untouched.q.tobytes()


def test_what_is_kept_is_bounded_and_goes_with_the_robot() -> None:
    robot = robot_of("planar")
    names = [f"task {k}" for k in range(pool.KEPT + 5)]
    for name in names:
        solve_ik(robot, PositionTask([0.9, 0.4], gain=1.0, name=name))
    assert kept(robot) == pool.KEPT
    task = PositionTask([0.9, 0.4], gain=1.0)
    gone = weakref.ref(task), weakref.ref(robot)
    solve_ik(robot, task)
    assert kept(pickle.loads(pickle.dumps(robot))) == kept(copy.copy(robot)) == kept(copy.deepcopy(robot)) == 0
    del task, robot
    gc.collect()
    assert [ref() for ref in gone] == [None, None]


def test_a_call_that_is_interrupted_spoils_no_later_one() -> None:
    robot, calls = robot_of("planar"), [0]
    task = PositionTask([0.9, 0.4], gain=1.0)
    expected = told(copy.deepcopy(robot), task)
    solve_ik(robot, task)
    problem = next(iter(pool._kept(robot).values()))
    integrate = problem.integrate

    def interrupted(*told: Any) -> Any:
        calls[0] += 1
        if calls[0] == 2:
            raise KeyboardInterrupt
        return integrate(*told)

    problem.integrate = interrupted
    with pytest.raises(KeyboardInterrupt):
        solve_ik(robot, task)
    assert kept(robot) == 0
    assert told(robot, task) == expected


def test_threads_have_problems_of_their_own() -> None:
    """A planar arm has no workspace that its states share: threads may solve on the same one."""
    robot = robot_of("planar")
    goals = [[0.9, 0.1 * k] for k in range(6)]
    expected = [told(copy.deepcopy(robot), PositionTask(goal, gain=1.0)) for goal in goals]
    found: list[list[tuple[Any, ...]]] = [[], [], []]

    def work(mine: list[tuple[Any, ...]]) -> None:
        mine += [told(robot, PositionTask(goal, gain=1.0)) for goal in goals]

    threads = [threading.Thread(target=work, args=(mine,)) for mine in found]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 3
    assert kept(robot) == 0  # of this thread
