"""Joints that follow others are where the file says, and neither leader nor follower leaves its range."""

from __future__ import annotations

import logging

import numpy as np
import pinocchio as pin
import pytest
from plain import from_states
from urdf_files import chain, write

from hqp import InvalidInput
from tasks import (
    CenterOfMassTask,
    Controller,
    JointLimits,
    PoseTask,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
    solve_ik,
)

pytestmark = pytest.mark.usefixtures("nothing_told")


# Joints that follow others.

TIES = {
    "plain": ([{}, {}, {"mimic": ("joint1", -0.5, 0.2)}], {"joint2": ("joint1", -0.5, 0.2)}),
    "a slide follows a hinge": (
        [{}, {}, {"kind": "prismatic", "mimic": ("joint0", 0.1, 0.05)}],
        {"joint2": ("joint0", 0.1, 0.05)},
    ),
    "the leader comes later": ([{"mimic": ("joint2", 0.5, 0.1)}, {}, {}], {"joint0": ("joint2", 0.5, 0.1)}),
    "a chain": (
        [{}, {"mimic": ("joint0", 0.5, 0.1)}, {"mimic": ("joint1", -2.0, 0.3)}],
        {"joint1": ("joint0", 0.5, 0.1), "joint2": ("joint0", -1.0, 0.1)},
    ),
    "two followers, one before": (
        [{"mimic": ("joint1", -1.0, 0.0)}, {}, {"mimic": ("joint1", 0.25, -0.1)}],
        {"joint0": ("joint1", -1.0, 0.0), "joint2": ("joint1", 0.25, -0.1)},
    ),
    "a leader that is fixed": ([{}, {"kind": "fixed"}, {"mimic": ("joint1", 2.0, 0.3)}], {"joint2": (None, 0.0, 0.3)}),
    "a factor of zero": ([{}, {}, {"mimic": ("joint1", 0.0, 0.3)}], {"joint2": (None, 0.0, 0.3)}),
    "both without end": (
        [{}, {"kind": "continuous"}, {"kind": "continuous", "mimic": ("joint1", -0.5, 0.1)}],
        {"joint2": ("joint1", -0.5, 0.1)},
    ),
    "a range follows what has no end": (
        [{}, {"kind": "continuous"}, {"mimic": ("joint1", 0.25, 0.1)}],
        {"joint2": ("joint1", 0.25, 0.1)},
    ),
}


def tied(tmp_path, name, **options):
    parts, ties = TIES[name]
    path = write(tmp_path, *chain(*parts), links=4)
    return load_robot(path, tip="link3", **options), load_robot(path, tip="link3", mimic="free"), ties


def unfolded(follows, free, ties, q):
    """The joints of a robot with ties, each on its own, by the words of the file."""
    known = {name: float(value) for name, value, _, _ in follows.describe(q)}
    for _ in range(3):  # a leader may be known by its follower
        for follower, (leader, factor, offset) in ties.items():
            if leader is None:
                known[follower] = offset
            elif leader in known:
                known[follower] = factor * known[leader] + offset
            elif follower in known:
                known[leader] = (known[follower] - offset) / factor
    whole = pin.neutral(free.model)
    for name, value in known.items():
        own = free.model.joints[free.model.getJointId(name)]
        whole[own.idx_q : own.idx_q + own.nq] = value if own.nq == 1 else [np.cos(value), np.sin(value)]
    return known, whole


@pytest.mark.parametrize("name", TIES)
def test_followers_are_where_the_file_says(tmp_path, name):
    follows, free, ties = tied(tmp_path, name, mimic="follow")
    rng = np.random.default_rng(3)
    for _ in range(5):
        q = follows.random(rng)
        _, whole = unfolded(follows, free, ties, q)
        here, there = follows.at(q, np.zeros(follows.nv)), free.at(whole, np.zeros(free.nv))
        for frame in "link1", "link2", "link3":
            np.testing.assert_allclose(here.frame(frame).position, there.frame(frame).position, atol=1e-12)
            np.testing.assert_allclose(here.frame(frame).rotation, there.frame(frame).rotation, atol=1e-12)
        assert here.center_of_mass.position == pytest.approx(there.center_of_mass.position, abs=1e-12)


@pytest.mark.parametrize("mimic", ["follow", "lock"])
@pytest.mark.parametrize("name", TIES)
def test_neither_leader_nor_follower_leaves_its_range(tmp_path, name, mimic):
    robot, free, ties = tied(tmp_path, name, mimic=mimic)
    if mimic == "lock":
        assert not set(ties) & set(robot.joint_names)
    for way in 1.0, -1.0:
        goal = PostureTask(robot.integrate(robot.neutral, np.full(robot.nv, 9.0 * way)), gain=2.0)
        record = simulate(
            Controller(robot, JointLimits() >> goal, dt=0.02, damping=None), robot.home, duration=3.0, certify=50
        )
        assert record.stopped is None
        assert record.certified_share == 1.0
        found = [*record.q[::10], record.q[-1], solve_ik(robot, goal, restarts=False, iterations=60).q]
        speeds = np.abs(record.v).max(axis=0)
        for q in found:
            if mimic == "follow":
                known, _ = unfolded(robot, free, ties, q)
                for joint_name, value in known.items():
                    low, high = free.position_limit[:, free.joint_names.index(joint_name)]
                    assert low - 1e-9 <= value <= high + 1e-9, joint_name
        for follower, (leader, factor, _) in ties.items():
            for one, other, share in (leader, follower, abs(factor)), (follower, leader, 1.0 / (abs(factor) or 1.0)):
                if one in robot.joint_names and other in free.joint_names:
                    own = speeds[robot.joint_names.index(one)] * share
                    assert own <= free.velocity_limit[free.joint_names.index(other)] + 1e-9


@pytest.mark.parametrize("name", TIES)
def test_held_followers_stand_where_their_leader_does(tmp_path, name):
    held, free, ties = tied(tmp_path, name, mimic="lock")
    q = held.configuration({name: 0.1 for name in held.joint_names if name in ("joint0",)} if len(ties) < 2 else {})
    _, whole = unfolded(held, free, {}, q)
    neutral = {name: 0.0 for name in free.joint_names if name not in held.joint_names}
    for follower, (leader, factor, offset) in ties.items():
        rest = next((value for joint_name, value, *_ in held.describe(held.neutral) if joint_name == leader), 0.0)
        neutral[follower] = offset if leader is None else factor * rest + offset
    for joint_name, value in neutral.items():
        own = free.model.joints[free.model.getJointId(joint_name)]
        whole[own.idx_q : own.idx_q + own.nq] = value if own.nq == 1 else [np.cos(value), np.sin(value)]
    here, there = (robot.at(x, np.zeros(robot.nv)).frame() for robot, x in ((held, q), (free, whole)))
    np.testing.assert_allclose(here.position, there.position, atol=1e-12)


@pytest.mark.parametrize("name", TIES)
def test_compiled_rows_know_followers(tmp_path, name):
    """The rows that loops write from Pinocchio's columns are those of the frames that its states tell."""
    robot, *_ = tied(tmp_path, name, mimic="follow")
    rng = np.random.default_rng(5)
    stack = (
        JointLimits()
        >> PoseTask([0.1, 0.2, 0.3], np.eye(3), gain=2.0)
        >> CenterOfMassTask([0.0, 0.1, 0.2], gain=1.0)
        >> PositionTask([0.1, 0.2, 0.3], frame="link2", gain=2.0)
    )
    fast, slow = (stack.build(one, "velocity", 0.01) for one in (robot, from_states(robot)))
    for _ in range(4):
        state = robot.at(robot.random(rng), rng.uniform(-1.0, 1.0, robot.nv))
        for rows in fast, slow:
            rows.fill(state, 0.0)
        np.testing.assert_allclose(fast.hierarchy.dense(), slow.hierarchy.dense(), atol=1e-12)
        np.testing.assert_allclose(fast.hierarchy.lower, slow.hierarchy.lower, atol=1e-12)


def test_a_joint_of_a_tie_that_is_locked_takes_the_others_with_it(tmp_path):
    path = write(tmp_path, *chain(*TIES["plain"][0]), links=4)
    free = load_robot(path, tip="link3", mimic="free")
    for lock in {"joint1": 0.4}, {"joint2": 0.0}, {"joint1": 0.4, "joint2": 0.0}:
        robot = load_robot(path, tip="link3", mimic="follow", lock=lock)
        assert robot.joint_names == ("joint0",)
        place = free.at([0.3, 0.4, 0.0], np.zeros(3)).frame().position
        np.testing.assert_allclose(robot.at([0.3], [0.0]).frame().position, place, atol=1e-12)
    with pytest.raises(InvalidInput, match=r"lock holds 'joint2' at 0\.5; as it follows 'joint1', it must be 0"):
        load_robot(path, mimic="follow", lock={"joint1": 0.4, "joint2": 0.5})


def test_a_tie_that_leaves_one_place_leaves_one_place(tmp_path):
    """A range that is narrowed to 0 .. 0 is one, and not a file's word for none."""
    path = write(tmp_path, *chain({"lower": 0.0}, {"lower": 0.0, "mimic": ("joint0", -1.0, 0.0)}, {}), links=4)
    for mimic in "lock", "follow":
        robot = load_robot(path, mimic=mimic)
        np.testing.assert_array_equal(robot.position_limit[:, 0], [0.0, 0.0])
        assert solve_ik(robot, PostureTask([0.7, 0.0], gain=1.0)).q[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("mimic", ["lock", "follow"])
def test_limits_by_hand_leave_followers_in_their_ranges(tmp_path, mimic):
    path = write(tmp_path, *chain({}, {}, {"speed": 1.0, "mimic": ("joint1", -2.0, 0.2)}), links=4)
    allowed = [-0.4, 0.6]  # where -2 q + 0.2 is between -1 and 1
    for given in {"joint1": (-0.9, 0.9)}, ([-3.0, -3.0], [3.0, 3.0]), (-2.0, 2.0):
        robot = load_robot(path, mimic=mimic, position_limit=given, velocity_limit=7.0)
        np.testing.assert_allclose(robot.position_limit[:, 1], allowed)
        np.testing.assert_allclose(robot.velocity_limit, [7.0, 0.5])
    assert load_robot(path, mimic=mimic, position_limit={"joint1": (0, 0.1)}).position_limit[:, 1].tolist() == [0, 0.1]
    with pytest.raises(InvalidInput, match="'joint2' follows 'joint1', and the ranges of both leave it no position"):
        load_robot(path, mimic=mimic, position_limit={"joint1": (0.8, 0.9)})
    with pytest.raises(InvalidInput, match=r"'joint1' from 0\.8 to 0\.9; those that follow it need -0\.4"):
        load_robot(path, mimic=mimic, position_limit=(0.8, 0.9))


def test_limits_by_hand_leave_all_that_are_tied_in_their_ranges(tmp_path):
    """Also where a follower comes first in the tree, and is the independent joint: the leader keeps its own limits."""
    parts = [
        {"lower": -10, "upper": 10, "speed": 10, "mimic": ("joint1", 2.0, 0.0)},
        {"lower": -1, "upper": 1, "speed": 1},
    ]
    path = write(tmp_path, *chain(*parts), links=3)
    for position, velocity in (({"joint0": (-5, 5)}, {"joint0": 8.0}), ((-5.0, 5.0), [8.0]), ([[-5.0], [5.0]], 8.0)):
        robot = load_robot(path, mimic="follow", position_limit=position, velocity_limit=velocity)
        assert robot.joint_names == ("joint0",)
        np.testing.assert_allclose(robot.position_limit[:, 0], [-2.0, 2.0])
        np.testing.assert_allclose(robot.velocity_limit, [2.0])
    named = load_robot(path, mimic="follow", position_limit={"joint1": (-0.5, 0.5)}, velocity_limit={"joint1": 0.25})
    np.testing.assert_allclose(named.position_limit[:, 0], [-1.0, 1.0])
    np.testing.assert_allclose(named.velocity_limit, [0.5])
    for mimic in "lock", "follow":
        assert load_robot("panda", mimic=mimic, velocity_limit=[1.0] * 8).velocity_limit.tolist() == [1.0] * 7 + [0.2]
    with pytest.raises(InvalidInput, match="position limit of joint 'joint1': it is held"):
        load_robot(path, mimic="free", lock=["joint1"], position_limit={"joint1": (-0.5, 0.5)})


def test_a_held_follower_stands_where_limits_by_hand_put_its_leader(tmp_path):
    path = write(tmp_path, *chain({}, {}, {"mimic": ("joint1", 1.0, 0.0)}), links=4)
    free = load_robot(path, tip="link3", mimic="free")
    held = load_robot(path, tip="link3", position_limit={"joint1": (0.5, 0.8)})
    np.testing.assert_allclose(held.neutral, [0.0, 0.5])
    expected = free.at([0.0, 0.5, 0.5], np.zeros(3)).frame().position
    np.testing.assert_allclose(held.at(held.neutral, np.zeros(2)).frame().position, expected, atol=1e-12)


def test_a_tie_that_cannot_move_is_told(tmp_path, caplog):
    path = write(tmp_path, *chain({"lower": 0.0}, {"lower": 0.0, "mimic": ("joint0", -1.0, 0.0)}, {}), links=4)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        load_robot(path)
    assert "joint 'joint0' cannot move: its range and that of 'joint1' leave it 0 alone" in caplog.text


def test_the_motor_of_a_tie_is_that_of_its_leader(tmp_path):
    parts = [{"mimic": ("joint1", 2.0, 0.0)}, {}]
    path = write(tmp_path, *chain(*parts), links=3)
    path.write_text(path.read_text().replace('effort="9"', 'effort="1000"', 1))
    robot = load_robot(path, mimic="follow")
    assert robot.joint_names == ("joint0",)
    np.testing.assert_allclose(robot.torque_limit, [4.5])  # 9 N m at the leader, which turns half as fast


@pytest.mark.parametrize("between", ["revolute", "prismatic", "planar", "floating"])
def test_the_mass_matrix_with_followers_is_that_of_the_whole(tmp_path, between):
    """M = G' M G, with G how all joints follow those that are free; from call to call, wherever the robot was."""
    parts = [{}, {"kind": between}, {"axis": "1 0 0", "mimic": ("joint0", -0.5, 0.2)}, {"axis": "0 1 0"}]
    path = write(tmp_path, *chain(*parts), links=5)
    follows, free = (load_robot(path, mimic=mimic) for mimic in ("follow", "free"))
    G = np.eye(free.nv)
    follower, leader = (free.joint_names.index(name) for name in ("joint2", "joint0"))
    G[follower, leader] = -0.5
    G = np.delete(G, follower, axis=1)
    rng = np.random.default_rng(4)
    qs = [follows.random(rng) for _ in range(3)]
    for q in [*qs, *qs]:
        known = {name: value for name, value, *_ in follows.describe(q)}
        whole = free.neutral.copy()
        place = free.model.joints[2]
        whole[place.idx_q : place.idx_q + place.nq] = q[1 : 1 + place.nq]
        for name, value in {**known, "joint2": -0.5 * known["joint0"] + 0.2}.items():
            if free.model.existJointName(name):
                own = free.model.joints[free.model.getJointId(name)]
                if own.nq == 1:
                    whole[own.idx_q] = value
        np.testing.assert_allclose(follows.mass_matrix(q), G.T @ free.mass_matrix(whole) @ G, atol=1e-10)
        v, a = rng.uniform(-1.0, 1.0, (2, follows.nv))
        torque = follows.mass_matrix(q) @ a + follows.bias(q, v)
        np.testing.assert_allclose(follows.inverse_dynamics(q, v, a), torque, atol=1e-9)


def test_holding_without_a_number_holds_in_the_range_and_in_the_tie(tmp_path):
    assert load_robot("panda", lock=["panda_joint4"]).nv == 7
    path = write(tmp_path, *chain({"lower": 0.5}, {}, {}), links=4)
    free = load_robot(path, tip="link3")
    np.testing.assert_array_equal(free.neutral, [0.5, 0.0, 0.0])
    held = load_robot(path, tip="link3", lock=["joint0"])
    places = (robot.at(robot.neutral, np.zeros(robot.nv)).frame().position for robot in (free, held))
    np.testing.assert_allclose(*places, atol=1e-12)
    for name in "plain", "a leader that is fixed":
        path = write(tmp_path, *chain(*TIES[name][0]), links=4)
        for mimic in "lock", "follow":
            one, other = (load_robot(path, tip="link3", mimic=mimic, lock=lock) for lock in ((), ["joint2"]))
            if one.nv == other.nv:  # held anyhow
                places = (robot.at(robot.neutral, np.zeros(robot.nv)).frame().position for robot in (one, other))
                np.testing.assert_allclose(*places, atol=1e-12)
    for mimic in "lock", "follow":
        with pytest.raises(InvalidInput, match=r"lock holds 'joint2' at 0.2; it must be 0.3"):
            load_robot(path, mimic=mimic, lock={"joint2": 0.2})


REFUSED_TIES = {
    "missing": ([{}, {"mimic": ("nobody", 1.0, 0.0)}], "'joint1' follows 'nobody', and 'nobody' is no joint"),
    "itself": ([{}, {"mimic": ("joint1", 1.0, 0.0)}], "'joint1' follows itself"),
    "in a circle": (
        [{"mimic": ("joint1", 1.0, 0.0)}, {"mimic": ("joint0", 1.0, 0.0)}],
        "follows itself, by 'joint0' and 'joint1'",
    ),
    "no range left": (
        [{}, {"mimic": ("joint0", 1.0, 5.0)}],
        "'joint1' follows 'joint0', and the ranges of both leave it no",
    ),
    "no number": ([{}, {"mimic": ("joint0", "x", 0.0)}], "mimic of joint 'joint1': multiplier = 'x' must be a finite"),
    "a base": (
        [{"kind": "floating"}, {"mimic": ("joint0", 1.0, 0.0)}],
        "'joint1' follows 'joint0'; 'joint0' must have one position",
    ),
}


@pytest.mark.parametrize("name", REFUSED_TIES)
def test_ties_that_mean_nothing(tmp_path, name):
    parts, said = REFUSED_TIES[name]
    path = write(tmp_path, *chain(*parts), links=3)
    for mimic in "lock", "follow":
        with pytest.raises(InvalidInput, match=said):
            load_robot(path, mimic=mimic)
    if name == "missing":
        assert load_robot(path, lock={"joint1": 0.2}).joint_names == ("joint0",)
    if name not in ("no number", "itself"):
        assert load_robot(path, mimic="free").nv >= 2
