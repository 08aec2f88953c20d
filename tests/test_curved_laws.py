"""Laws of damping by curvature: the same tasks, said in other words, give the same motion."""

from __future__ import annotations

from functools import reduce
from operator import rshift

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tasks import (
    AtMost,
    AxisTask,
    BoxLimit,
    Controller,
    Freeze,
    JointAccelerationLimit,
    JointCouplingTask,
    JointLimits,
    JointVelocityLimit,
    LookAtTask,
    OrientationTask,
    PlanarArm,
    PlaneLimit,
    PositionTask,
    PostureTask,
    TargetTask,
    load_robot,
)

DT, N = 0.01, 4
#: From exactly straight, where singular values are zero, to well bent; with a target out of reach, and one in reach.
BENDS, FAR, NEAR = (0.0, 0.01, 0.1, 0.3, 1.0), [1.9, 0.6], [0.9, 0.5]


def arm():
    return PlanarArm([0.5, 0.4, 0.3, 0.2], velocity_limit=3.0)


def tip(target, **options):
    return PositionTask(target, gain=5.0, **options)


def posture():
    return PostureTask([0.4, 1.0, 0.7, 0.5], gain=1.0)


def states():
    for k, bend in enumerate(BENDS):
        rng = np.random.default_rng(k)
        yield np.array([0.3, 0.0, 0.0, 0.0]) + bend * rng.uniform(-1.0, 1.0, N), np.zeros(N)
        yield np.array([0.3, 0.0, 0.0, 0.0]) + bend * rng.uniform(-1.0, 1.0, N), rng.normal(0.0, 0.2, N)


def answer(stack, q, v):
    return Controller(arm(), JointLimits() >> stack >> posture(), dt=DT)(q, v)


HALF = 0.5**0.5
SAME = {
    "a level with another weight": lambda target: tip(target, weight=3.0),
    "twice on the level": lambda target: tip(target, weight=HALF) + tip(target, weight=HALF, name="again"),
    "three times on the level": lambda target: (
        tip(target, weight=0.6) + tip(target, weight=0.6, name="again") + tip(target, weight=0.28**0.5, name="third")
    ),
}


@pytest.mark.parametrize("target", [FAR, NEAR], ids=["far", "near"])
@pytest.mark.parametrize("words", SAME)
def test_weights_of_a_level_as_a_whole_change_nothing(words: str, target: list[float]) -> None:
    damped = 0
    for q, v in states():
        once, other = answer(tip(target), q, v), answer(SAME[words](target), q, v)
        np.testing.assert_allclose(other.v, once.v, atol=1e-4)
        assert len(other.relaxed) == len(once.relaxed)
        damped += len(once.relaxed)
    assert damped


@pytest.mark.parametrize("target", [FAR, NEAR], ids=["far", "near"])
@pytest.mark.parametrize("turn", [0.4, 1.3, -2.2])
def test_a_plane_that_is_turned_turns_the_motion(turn: float, target: list[float]) -> None:
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ target
    first = np.array([turn, 0.0, 0.0, 0.0])
    for q, v in states():
        rest = PostureTask(np.array([0.4, 1.0, 0.7, 0.5]) + first, gain=1.0)
        other = Controller(arm(), JointLimits() >> tip(turned) >> rest, dt=DT)(q + first, v)
        np.testing.assert_allclose(other.v, answer(tip(target), q, v).v, atol=1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_a_first_joint_that_is_turned_turns_the_motion(seed: int) -> None:
    """Its axis is that of z: the world is turned with it, and the joint is far from its ends."""
    robot, rng, turn = load_robot("panda", lock=["panda_finger_joint1"]), np.random.default_rng(seed), 0.7
    about_z = Rotation.from_rotvec([0.0, 0.0, turn])
    q, v, first = robot.home + rng.uniform(-0.2, 0.2, 7), 0.1 * rng.standard_normal(7), turn * np.eye(7)[0]
    here = robot.at(q).frame("panda_hand")
    position = here.position + rng.choice([0.05, 0.6]) * rng.standard_normal(3)
    rotation = Rotation.from_rotvec(rng.standard_normal(3)) * Rotation.from_matrix(here.rotation)

    def after(change: Rotation, more: np.ndarray) -> np.ndarray:
        stack = (
            JointLimits()
            >> PositionTask(change.apply(position), frame="panda_hand", gain=20.0)
            >> OrientationTask((change * rotation).as_matrix(), frame="panda_hand", gain=20.0)
            >> PostureTask(robot.home + more, gain=1.0)
        )
        return Controller(robot, stack, dt=DT)(q + more, v).v

    once = after(Rotation.identity(), np.zeros(7))
    np.testing.assert_allclose(after(about_z, first), once, atol=1e-4)


@pytest.mark.parametrize("seed", range(4))
def test_the_order_of_the_tasks_of_a_level_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(0.0, 0.3, N), rng.uniform(-0.5, 0.5, N)
    together = [tip([0.9, 0.8], weight=3.0), PostureTask([0.2] * N, gain=1.0, weight=0.1)]
    one, other = (  # six rows of four joints, the longest first or the shortest
        answer(tip([1.7, 0.3]) >> first + second, q, v) for first, second in (together, together[::-1])
    )
    assert one.relaxed[0].damping > 0.0
    np.testing.assert_allclose(other.v, one.v, atol=1e-8)


#: A bent arm, and a target that is 2 cm away.
BENT = np.array([0.1, 0.8, 0.6, 0.4])
CLOSE = np.array([0.02, -0.01]) + arm().at(BENT, np.zeros(N)).pose[:2]
REDUNDANT = {
    "the same again below": lambda: tip(CLOSE) >> tip(CLOSE, name="again"),
    "the same again, beside": lambda: tip(CLOSE) + tip(CLOSE, name="again", weight=2.0),
    "a pose below its position": lambda: tip(CLOSE) >> tip(CLOSE, name="again") + OrientationTask(1.88, gain=5.0),
    "a posture twice": lambda: tip(CLOSE) >> PostureTask([0.4] * N, gain=1.0) >> PostureTask([0.5] * N, gain=1.0),
}


@pytest.mark.parametrize("said", REDUNDANT)
def test_in_reach_rows_that_repeat_others_leave_the_stack_strict(said: str) -> None:
    stack = JointLimits() >> REDUNDANT[said]() >> posture()
    for v in np.zeros(N), np.array([0.2, -0.1, 0.1, 0.2]):
        default, strict = (Controller(arm(), stack, dt=DT, damping=damping)(BENT, v) for damping in ("curvature", None))
        assert default.relaxed == ()
        np.testing.assert_array_equal(default.v, strict.v)


def test_a_direction_above_a_whole_orientation_leaves_the_stack_strict() -> None:
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    here, q = robot.at(robot.home, np.zeros(robot.nv)).frame(), robot.home + 0.002
    hand, turn = PositionTask(here.position, gain=20.0), OrientationTask(here.rotation, gain=20.0)
    for level in AxisTask(here.rotation[:, 2], gain=20.0), PositionTask(here.position, gain=5.0, name="again"):
        stack = JointLimits() >> hand >> level >> turn >> PostureTask(robot.home, gain=1.0)
        default, strict = (Controller(robot, stack, dt=0.005, damping=damping) for damping in ("curvature", None))
        step = default(q, np.zeros(robot.nv))
        assert step.relaxed == ()
        np.testing.assert_array_equal(step.v, strict(q, np.zeros(robot.nv)).v)


def held(robot, joint):
    """A joint held in three ways, each with how far the motion may differ from that of a robot that has it locked."""
    yield lambda task: Freeze([joint]) >> JointLimits() >> task, 1e-6
    yield lambda task: JointLimits() >> Freeze([joint]) >> task, 1e-6
    yield lambda task: JointLimits() >> PostureTask([0.0], joints=[joint], gain=20.0) >> task, 0.05


@pytest.mark.parametrize("seed", range(6))
def test_a_joint_that_is_held_is_as_good_as_locked(seed: int) -> None:
    joint, at = "panda_joint3", 2
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    locked = load_robot("panda", lock={"panda_finger_joint1": 0.0, joint: 0.0})
    rng, home = np.random.default_rng(seed), np.where(np.arange(robot.nv) == at, 0.0, robot.home)
    q, v = np.clip(home + rng.normal(0.0, 0.5, robot.nv), *robot.position_limit), rng.normal(0.0, 0.3, robot.nv)
    q[at] = v[at] = 0.0
    here = robot.at(q, v).frame()
    hand = PositionTask(here.position + rng.normal(0.0, 0.5, 3), gain=20.0)
    turn = OrientationTask(robot.at(home, v).frame().rotation, gain=20.0)
    stack = JointLimits() >> hand >> turn >> PostureTask(np.delete(home, at), gain=1.0)
    expected = Controller(locked, stack, dt=0.005)(np.delete(q, at), np.delete(v, at))
    assert expected.relaxed[0].damping > 0.0
    for hold, off in held(robot, joint):
        stack = hold(hand) >> turn >> PostureTask(home, gain=1.0)
        step = Controller(robot, stack, dt=0.005)(q, v)
        np.testing.assert_allclose(np.delete(step.v, at), expected.v, atol=off)


@pytest.mark.parametrize("bend", [0.0, 1e-6, 1e-3])
def test_repeated_rows_do_not_hide_a_singularity(bend: float) -> None:
    q = np.array([0.3, bend, -bend, bend])
    once, twice = answer(tip(FAR), q, np.zeros(N)), answer(tip(FAR) >> tip(FAR, name="again"), q, np.zeros(N))
    assert once.relaxed[0].damping > 0.1
    assert twice.relaxed[0].damping == pytest.approx(once.relaxed[0].damping)
    assert twice.relaxed[1].damping > 0.1


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("target", [FAR, NEAR], ids=["far", "near"])
def test_a_row_that_is_held_above_already_changes_nothing_below(target: list[float], order: str) -> None:
    """Across what is held above nothing of it is left but round-off, whose direction means nothing."""
    robot = PlanarArm([0.5, 0.4, 0.3, 0.2, 0.2], velocity_limit=3.0, acceleration_limit=30.0)
    rest, damped = PostureTask([0.4, 1.0, 0.7, 0.5, 0.3], gain=1.0), 0

    def tied(name: str) -> JointCouplingTask:
        return JointCouplingTask({0: 0.3, 1: 0.7, 2: -0.4}, gain=3.0, name=name)

    for seed in range(30):
        rng = np.random.default_rng(seed)
        q, v = rng.uniform(-1.0, 1.0, 5) * rng.choice([0.02, 0.3, 1.0]), rng.normal(0.0, 0.3, 5)
        once, *others = (
            Controller(robot, JointLimits() >> tied("tied") >> low >> rest, order=order, dt=DT)(q, v)
            for low in (tip(target), tied("again") + tip(target), tip(target) + tied("again"))
        )
        for other in others:
            size = np.abs(once.solution.x).max()
            np.testing.assert_allclose(other.solution.x, once.solution.x, atol=1e-3 * max(1.0, size))
        damped += len(once.relaxed)
    assert damped > 30


class OwnTip(TargetTask):
    """A task of one's own, whose curvature nobody tells: the position of the tip."""

    rows = 2

    def measure(self, state):
        return state.pose[:2]

    def jacobian(self, state):
        return state.jacobian[:2]


def test_rows_whose_curvature_is_not_known_are_no_singularity() -> None:
    stack = JointLimits() >> OwnTip(CLOSE, gain=5.0) >> tip(CLOSE) >> posture()
    default, strict = (Controller(arm(), stack, dt=DT, damping=damping)(BENT) for damping in ("curvature", None))
    assert default.relaxed == ()
    np.testing.assert_allclose(default.v, strict.v, atol=1e-9)


def largest_jump(answer, begin, end, halvings=25):
    """How far the answer jumps between two states, where it changes most: the interval is halved again and again."""
    first, last = answer(begin), answer(end)
    for _ in range(halvings):
        middle = 0.5 * (begin + end)
        found = answer(middle)
        if np.abs(found - first).max() < np.abs(found - last).max():
            begin, first = middle, found
        else:
            end, last = middle, found
    return np.abs(first - last).max()


def test_no_row_jumps_where_another_one_goes_from_soft_to_held() -> None:
    """An arm that is nearly straight, and turned away from what it is asked for, on its way between two ticks.

    Its speeds are about 1 rad/s. A row of the position goes from the largest stiffness to held: what that is worth.
    """
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    hand, turn = (
        PositionTask([0.68337, -0.29166, 0.90232], gain=20.0),
        OrientationTask(np.diag([1.0, -1.0, -1.0]), gain=20.0),
    )
    controller = Controller(robot, JointLimits() >> hand >> turn >> PostureTask(robot.home, gain=1.0), dt=0.005)
    begin = [-0.43838, 0.52128, 0.08115, -0.59788, 0.03728, 2.74743, 0.40814]
    begin += [-0.15605, -0.46858, 0.03985, -0.5368, 0.20279, -0.88887, -0.13256]
    end = [-0.43915, 0.51897, 0.08134, -0.60052, 0.03829, 2.74297, 0.40749]
    end += [-0.15366, -0.46277, 0.03684, -0.52649, 0.20233, -0.89103, -0.13045]
    assert largest_jump(lambda x: controller(x[:7], x[7:]).v, np.array(begin), np.array(end)) < 0.05


@pytest.mark.parametrize("beyond", [0.2, 0.4], ids="{:g} m".format)
def test_levels_below_hardly_move_a_first_level_however_far_its_target_is(beyond: float) -> None:
    """A hand at rest out of reach, turned away from what a level below asks for; against the same hand left alone."""
    robot, target = load_robot("panda", lock=["panda_finger_joint1"]), np.array([0.8 + beyond, 0.2, 0.6])
    hand, turn = PositionTask(target, gain=20.0), OrientationTask(np.diag([1.0, -1.0, -1.0]), gain=20.0)
    q, v, far, told = robot.home, np.zeros(robot.nv), [], 0.0
    for below in (turn >> PostureTask(robot.home, gain=1.0), None):
        stack = JointLimits() >> hand if below is None else JointLimits() >> hand >> below
        controller = Controller(robot, stack, dt=0.005)
        for _ in range(600):
            step = controller(q, v)
            v = step.v
            q = robot.integrate(q, 0.005 * v)
        told = max(told, step.relaxed[0].moved)
        far.append(np.linalg.norm(target - robot.at(q, v).frame().position))
    assert far[0] < far[1] + 1e-3
    assert far[0] <= far[1] + told / 20.0, "the speed that is told, over the gain, bounds it: the hand pulls back"


def test_levels_below_move_a_hand_no_faster_than_is_told() -> None:
    """But for what is of second order in the time: no joint is farther than 1.3 m from the hand of this arm."""
    robot, dt, told = load_robot("panda", lock=["panda_finger_joint1"]), 0.005, 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        q, v = rng.uniform(*robot.position_limit), 0.3 * rng.standard_normal(robot.nv)
        target = robot.at(q, v).frame().position * rng.uniform(1.0, 2.5)
        stack = JointLimits() >> PositionTask(target, gain=20.0) >> PostureTask(robot.home, gain=5.0)
        controller = Controller(robot, stack, dt=dt)
        for _ in range(100):
            step = controller(q, v)
            for level in (level for level in step.relaxed if level.name == "position"):
                alone = next(own.x for own in step.solution.stages if len(own.hierarchy.levels) == level.level + 1)
                for h in dt, 1e-3 * dt:
                    ends = [robot.at(robot.integrate(q, h * x), v).frame().position for x in (step.v, alone)]
                    curved = 0.5 * 1.3 * h**2 * (np.abs(step.v).sum() ** 2 + np.abs(alone).sum() ** 2)
                    assert np.linalg.norm(ends[0] - ends[1]) <= h * level.moved + curved + 1e-12
                told += level.moved > 1e-3
            q, v = robot.integrate(q, dt * step.v), step.v
    assert told > 100


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("seed", range(12))
def test_mirrored_turned_or_larger_the_motion_is_the_same(seed: int, order: str) -> None:
    """Neither the axes of the world nor the unit of length mean anything."""
    rng, turn = np.random.default_rng(seed), 0.7
    lengths, angle = rng.uniform(0.2, 0.6, N), rng.uniform(-np.pi, np.pi)
    q = rng.uniform(-1.0, 1.0, N) * rng.choice([0.02, 0.3, 2.0])
    v, home = rng.uniform(-1.0, 1.0, N) * rng.choice([0.1, 2.9]), rng.uniform(-1.0, 1.0, N)
    target = rng.uniform(0.2, 2.0) * lengths.sum() * np.array([np.cos(angle), np.sin(angle)])

    def moved(q, v, home, target, angle, scale=1.0):
        robot = PlanarArm(scale * lengths, velocity_limit=3.0, acceleration_limit=30.0)
        place, turned = PositionTask(scale * target, gain=8.0), OrientationTask(angle, gain=6.0)
        limits = JointVelocityLimit() >> JointAccelerationLimit()
        stack = limits >> place >> turned >> PostureTask(home, gain=1.0)
        step = Controller(robot, stack, dt=DT, order=order)(q, v)
        assert step.relaxed
        return step.v if order == "velocity" else step.a

    once, first = moved(q, v, home, target, angle), turn * np.eye(N)[0]
    about = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    close = {"atol": 1e-9 * max(1.0, np.abs(once).max())}
    np.testing.assert_allclose(-moved(-q, -v, -home, target * [1.0, -1.0], -angle), once, **close)
    np.testing.assert_allclose(moved(q + first, v, home + first, about @ target, angle + turn), once, **close)
    for scale in 1e-3, 1e3:
        np.testing.assert_allclose(moved(q, v, home, target, angle, scale), once, **close)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("seed", range(12))
def test_a_bound_that_is_far_changes_nothing_on_any_level(seed: int, order: str) -> None:
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-1.0, 1.0, N) * rng.choice([0.02, 0.3, 2.0]), rng.uniform(-1.0, 1.0, N)
    robot = PlanarArm([0.5, 0.4, 0.3, 0.2], velocity_limit=3.0, acceleration_limit=30.0)

    def moved(place: int | None) -> np.ndarray:
        levels = [JointLimits(), tip(FAR), OrientationTask(0.5, gain=4.0), posture()]
        if place is not None:
            levels.insert(place, AtMost(PositionTask([100.0], mask="y", gain=4.0, name="far")))
        step = Controller(robot, reduce(rshift, levels), dt=DT, order=order)(q, v)
        assert step.relaxed
        assert step.solution.certify().ok
        return step.v if order == "velocity" else step.a

    once = moved(None)
    for place in range(1, 5):
        np.testing.assert_allclose(moved(place), once, atol=1e-9 * max(1.0, np.abs(once).max()))


def in_two(low: float, high: float):
    """A band of heights in words that differ, each with two ends, or with one."""
    far = np.array([-np.inf, np.inf])
    yield BoxLimit([-9.0, low], [9.0, high], gain=20.0)
    yield BoxLimit([-9.0, low], far[[1, 1]], gain=20.0) + BoxLimit(far[[0, 0]], [9.0, high], gain=20.0, name="below")
    up = PlaneLimit([0.0, 1.0, 0.0], low, gain=20.0)
    yield up + PlaneLimit([0.0, -1.0, 0.0], -high, gain=20.0, name="below")


@pytest.mark.parametrize("seed", range(8))
def test_it_does_not_matter_whether_a_band_is_told_in_one_row_or_in_two(seed: int) -> None:
    rng, robot = np.random.default_rng(seed), PlanarArm([0.5, 0.4, 0.3, 0.2], velocity_limit=3.0)
    q, v = 0.3 * rng.uniform(-1.0, 1.0, N), rng.uniform(-1.0, 1.0, N)
    height = robot.at(q, v).frame().position[1]
    one, *others = (
        Controller(robot, JointLimits() + band >> tip(FAR) >> OrientationTask(0.5, gain=6.0) >> posture(), dt=DT)(q, v)
        for band in in_two(height - 0.02, height + 0.02)
    )
    for other in others:
        np.testing.assert_allclose(other.v, one.v, atol=1e-9)


@pytest.mark.parametrize("seed", range(60))
def test_levels_below_keep_what_inequalities_above_have_left(seed: int) -> None:
    """A bound that pushes a level takes its direction, and a level that violates some rows violates others by that."""
    rng = np.random.default_rng(seed)
    robot = arm() if seed % 3 else load_robot("ur5")
    order, size = ("velocity", "acceleration")[seed % 2], 2 if seed % 3 else 3

    def task():
        made = PositionTask(rng.uniform(-0.8, 0.8, size), gain=rng.uniform(0.5, 20.0))
        return AtMost(made) if rng.random() < 0.5 else made

    levels = [JointVelocityLimit(rng.uniform(0.5, 3.0)), *(task() for _ in range(3))]
    stack = reduce(rshift, [*levels, PostureTask(rng.uniform(-1.0, 1.0, robot.nq), gain=1.0)])
    controller, q = Controller(robot, stack, order=order, dt=DT), rng.uniform(-1.5, 1.5, robot.nq)
    for _ in range(4):
        step = controller(q, rng.normal(0.0, 0.3, robot.nv))
        assert step.ok
        assert step.solution.certify().ok, str(step.solution.certify())


@pytest.mark.parametrize("seed", [*range(30), 38, 40, 47, 91, 124, 125, 161])
def test_of_joints_that_no_task_needs_not_round_off_decides(seed: int) -> None:
    """The last joint only turns the hand about the axis of its tasks; its motion hangs on nothing but the state."""
    rng, robot = np.random.default_rng(seed), load_robot(("ur3", "ur10")[seed % 2])
    point = robot.at(rng.uniform(-2.0, 2.0, 6)).frame().position

    def directed() -> AxisTask | LookAtTask:
        gain = rng.uniform(1.0, 40.0)
        return AxisTask(rng.normal(size=3), gain=gain) if rng.random() < 0.5 else LookAtTask(point + 1.0, gain=gain)

    stack = JointAccelerationLimit(30.0) >> JointLimits() >> directed() >> directed() >> tip(point + 0.3)
    if seed % 3:
        stack = JointAccelerationLimit(30.0) >> JointLimits() >> tip(point + 0.3) >> directed() >> directed()
    warm = Controller(robot, stack, order="acceleration", dt=DT)
    for _ in range(6):
        q, v = rng.uniform(-2.0, 2.0, 6), rng.uniform(-1.0, 1.0, 6)
        cold = Controller(robot, stack, order="acceleration", dt=DT)
        step = warm(q, v)
        np.testing.assert_allclose(step.a, cold(q, v).a, atol=1e-4)
        assert step.solution.certify().ok
