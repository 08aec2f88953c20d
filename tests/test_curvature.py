"""The curvature of tasks against differences of what they measure, on arms, humanoids and joints of every kind.

100 states a robot: ``python -m pytest -m sweep -k curvature``.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live_table import GROUPS, SETTINGS
from test_jacobians import NOW, ROBOTS, kinds, motion, robot_named

from hqp import InvalidInput
from tasks import (
    AtLeast,
    AtMost,
    AxisTask,
    CenterOfMassTask,
    JointMotion,
    OrientationTask,
    PinocchioRobot,
    PlanarArm,
    PlaneTask,
    PoseTask,
    PositionTask,
    Within,
    load_robot,
)
from tasks.base.loops import address, ready, run_all
from tasks.base.rotations import exp
from tasks.robots.chain import APART, carried, carried_in_tree, joint_by_joint
from tasks.rows.part import Tick
from tasks.rows.plan import plan_of
from tasks.rows.site import Site, Workspace

robots = pytest.mark.parametrize("name", ROBOTS)
#: Steps of differences of the error, and of half its square.
H = 1e-3
#: The linear and the angular coordinates that masked tasks of `kinds` have.
MASKS = {
    "position": (np.array([1.0, 0.0, 1.0]), 1.0),
    "orientation": (1.0, np.array([0.0, 1.0, 1.0])),
    "pose": (np.array([0.0, 1.0, 1.0]), np.array([1.0, 0.0, 1.0])),
}
X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


class AtWork:
    """A part at work by itself: what it measures and how it bends, at any configuration."""

    def __init__(self, part, robot, t=0.0, order="velocity"):
        rows = part.size(robot)
        self.robot, self.t, self.shared = robot, t, Workspace(robot, order, 0.01)
        self.site = Site(self.shared, np.zeros((rows, robot.nv)), *np.zeros((2, rows)))
        self.plan = plan_of(part, self.site)

    def at(self, q):
        """Error and rows."""
        state = self.robot.at(q, np.zeros(self.robot.nv))
        for move in self.plan.moves:
            move(self.t)
        self.shared.update(state)
        if self.plan.python is not None:
            self.plan.python(Tick(self.robot, state, self.t, self.shared.order, 0.01, self.shared.envelope))
        run_all(self.plan.calls)
        return self.site.measured[0].copy(), self.site.A.copy()

    def bend(self, q, weights):
        self.at(q)
        return self.plan.curvature_of(weights)

    def along(self, q, d, value, h=H):
        """The second derivative of what `value` makes of the error, along a step d."""
        integrate = getattr(self.robot, "integrate", np.add)
        far, near, here = (
            sum(value(self.at(integrate(q, s * h * d))[0]) for s in signs) for signs in ((-2, 2), (-1, 1), (0,))
        )
        return (-far + 16.0 * near - 30.0 * here) / (12.0 * h * h)


def half_square(e):
    return 0.5 * float(e @ e)


def unit_step(rng, n):
    d = rng.normal(size=n)
    return d / np.linalg.norm(d)


def exact(label):
    """Whether a task bends by what it tells at any error: see :mod:`tasks.rows.curvature`."""
    spatial = label.startswith("pose, world")
    return not (spatial or ("masked" in label and not label.startswith(("position, world", "position, local_world"))))


def somewhere(rng, robot, label, kind, size):
    """A random state, and a task whose target is in the order of `size` away, in the coordinates that it has."""
    q = robot.random(rng)
    m, near = motion(robot, q, np.zeros(robot.nv), kind), rng.uniform(-0.4, 0.4, (4, 3))
    what, axes = label.split(", ")[:2] if "," in label else (label, "")
    linear, angular = MASKS[what] if label.endswith("masked") else (1.0, 1.0)
    near[0], near[2] = linear * near[0], angular * near[2]
    if axes == "local":
        near[0], near[2] = m.R @ near[0], m.R @ near[2]
    elif (what, axes) == ("pose", "world"):
        near[0] -= np.cross(m.p, near[2])
    return q, kind.make(m, near, size)


#: Whose level is left strict, for they do not tell how they bend, and what is straight.
SILENT = {f"{wheel}{where}" for wheel in ("rolling", "omniwheel") for where in ("", ", relative")}
SILENT |= {"linear", "coupling", "posture of named joints"}


def check_square(name, seed):
    """Half the square of the error bends by J'J - S(e)."""
    robot, rng = robot_named(name), np.random.default_rng(seed)
    for label, kind in kinds(name).items():
        size = 0.3 if exact(label) else 1e-3
        q, task = somewhere(rng, robot, label, kind, size)
        work = AtWork(task, robot, NOW)
        if work.plan.curvature is None:
            assert label in SILENT
            continue
        e, J = work.at(q)
        d = unit_step(rng, robot.nv)
        S = work.plan.curvature_of(e)
        np.testing.assert_array_equal(S, S.T)
        told, found = (J @ d) @ (J @ d) - d @ S @ d, work.along(q, d, half_square)
        tolerance = 1e-7 * (1.0 + abs(found)) if exact(label) else 1e-8 + 30.0 * size**2
        assert abs(told - found) < tolerance, f"{name}: {label}: {told} is not {found}, |e| = {np.linalg.norm(e):.2g}"


def check_held(name, seed):
    """Where the rows hold a task at its target, it leaves that by half S(w), in whatever direction they leave free."""
    robot, rng = robot_named(name), np.random.default_rng(seed)
    for label, kind in kinds(name).items():
        q, task = somewhere(rng, robot, label, kind, 0.0)
        work = AtWork(task, robot, NOW)
        if work.plan.curvature is None:
            continue
        e, J = work.at(q)
        assert np.abs(e).max() < 1e-12
        w, d = rng.normal(size=len(e)), unit_step(rng, robot.nv)
        if label.startswith(("position", "orientation", "pose", "axis", "look")):
            d -= np.linalg.pinv(J) @ (J @ d)
        d /= max(np.linalg.norm(d), 0.1)  # an arm of six joints leaves a pose nothing free
        S = work.bend(q, w)
        # Of directions that are nearly parallel the error is 0: differences of it take longer steps.
        h, tolerance = (20.0 * H, 3e-5) if label.startswith(("axis", "look")) else (H, 1e-7)
        found = work.along(q, d, lambda e, w=w: -float(w @ e), h)
        assert abs(d @ S @ d - found) < tolerance * (1.0 + abs(found)), f"{name}: {label}"


@robots
@pytest.mark.parametrize("seed", range(2))
def test_half_the_square_of_an_error_bends_by_it(name, seed):
    check_square(name, seed)


@robots
@pytest.mark.parametrize("seed", range(2))
def test_what_rows_hold_leaves_its_place_by_it(name, seed):
    check_held(name, seed)


def bound_of(plan, rows):
    """F of the bound of a part, at the state of the last tick."""
    table, F = plan.curvature.table.numbers.copy(), np.zeros((rows, rows))
    table[0] = address(F)
    ready(plan.bound)(address(table))
    return F


@robots
@pytest.mark.parametrize("size", [1e-3, 0.3])
def test_bounds_are_above_the_norm_and_near_to_it(name, size):
    """Exact where no turn has a length."""
    robot, rng, bounded = robot_named(name), np.random.default_rng(4), 0
    for label, kind in kinds(name).items():
        q, task = somewhere(rng, robot, label, kind, size)
        work = AtWork(task, robot, NOW)
        if work.plan.bound is None:
            continue
        e, _ = work.at(q)
        F, bounded = bound_of(work.plan, len(e)), bounded + 1
        for w in (e, *rng.normal(size=(5, len(e)))):
            norm, most = np.linalg.norm(work.plan.curvature_of(w)), np.sqrt(w @ F @ w)
            assert norm <= most * (1.0 + 1e-9) + 1e-15, label
            if task.position is not None and task.rotation is not None:
                continue  # of both at once it is the root of twice the sum of squares
            # All curvature of what turns comes from the length of e where one joint alone turns it.
            longer = 0.1 * norm + 0.5 * size * np.linalg.norm(w) * robot.nv if task.rotation is not None else 0.0
            assert most <= norm * (1.0 + 1e-9) + longer, label
    assert bounded > 0


@pytest.mark.sweep
@robots
def test_curvature_at_many_states(name):
    for seed in range(2, 102):
        check_square(name, seed)
        check_held(name, seed)


# Joints of all kinds: the whole matrix.


def composite():
    joint = pin.JointModelComposite(pin.JointModelRX(), pin.SE3.Random())
    for part in pin.JointModelPY(), pin.JointModelRZ():
        joint.addJoint(part, pin.SE3.Random())
    return joint


JOINTS = {
    "hinge": pin.JointModelRY,
    "sliding": pin.JointModelPY,
    "screw": lambda: pin.JointModelHZ(0.2),
    "circle": pin.JointModelRUBY,
    "ball": pin.JointModelSpherical,
    "angles": pin.JointModelSphericalZYX,
    "universal": lambda: pin.JointModelUniversal(X, Y),
    "translation": pin.JointModelTranslation,
    "planar": pin.JointModelPlanar,
    "free": pin.JointModelFreeFlyer,
    "composite": composite,
}


@cache
def tree(name):
    """A hinge, this joint on it, and on that one two branches: a hinge with the tip, a slide with the side."""
    pin.seed(5)
    model = pin.Model()

    def add(parent, joint, called):
        index = model.addJoint(parent, joint, pin.SE3.Random(), called)
        model.appendBodyToJoint(index, pin.Inertia.Random(), pin.SE3.Identity())
        model.addFrame(pin.Frame(f"on {called}", index, 0, pin.SE3.Random(), pin.FrameType.OP_FRAME))
        return index

    middle = add(add(0, pin.JointModelRX(), "first"), JOINTS[name](), "middle")
    add(middle, pin.JointModelRZ(), "tip")
    add(add(middle, pin.JointModelRY(), "elbow"), pin.JointModelPX(), "side")
    model.lowerPositionLimit[:], model.upperPositionLimit[:] = -2.0, 2.0
    return PinocchioRobot(model, tip="on tip", name=name)


def made(rng, relative_to=None):
    R = exp(rng.uniform(-1.0, 1.0, 3))
    own = {"relative_to": relative_to, "gain": 1.0}
    yield PositionTask(rng.normal(size=3), **own)
    yield OrientationTask(R, **own)
    yield PoseTask(rng.normal(size=3), R, reference="local", **own)
    yield AxisTask(rng.normal(size=3), **own)
    yield CenterOfMassTask(rng.normal(size=3), **own)
    yield PlaneTask([1.0, 2.0, -1.0], 0.2, **own)


def check_whole(work, q, message, tolerance=3e-7):
    """Every entry of the matrix, by polarisation."""
    e, J = work.at(q)
    S, n = work.plan.curvature_of(e), len(J.T)
    each = np.eye(n)
    for a in range(n):
        for b in range(a, n):
            if a == b:
                found = work.along(q, each[a], half_square)
            else:
                found = 0.25 * sum(s * work.along(q, each[a] + s * each[b], half_square) for s in (1.0, -1.0))
            told = J[:, a] @ J[:, b] - S[a, b]
            assert abs(told - found) < tolerance * (1.0 + abs(found)), f"{message} [{a}, {b}]: {told} is not {found}"


@pytest.mark.parametrize("relative_to", [None, "on side", "on first"])
@pytest.mark.parametrize("name", JOINTS)
def test_every_entry_below_and_above_joints_of_every_kind(name, relative_to):
    rng, robot = np.random.default_rng(7), tree(name)
    for task in made(rng, relative_to):
        check_whole(AtWork(task, robot), robot.random(rng), f"{name}, {task!r}")


def test_a_joint_that_follows_another_bends_what_it_carries_alone():
    """Where one number moves two joints of a chain, nobody tells; so it is of the centre of mass."""
    robot, rng = load_robot("panda", mimic="follow"), np.random.default_rng(1)
    finger = PositionTask([0.3, 0.2, 0.5], frame="panda_rightfinger", gain=1.0)
    check_whole(AtWork(finger, robot), robot.random(rng), "right finger")
    assert AtWork(CenterOfMassTask([0.0, 0.0, 0.3], gain=1.0), robot).plan.curvature is None


angles = st.lists(st.floats(-4.0, 4.0), min_size=4, max_size=4)


@settings(max_examples=20, deadline=None)
@given(angles, st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=2), st.sampled_from([None, "link2", "link3"]))
def test_a_planar_arm_bends_towards_its_joints(q, target, frame):
    """Of the tip, S(w)[a, b] is - w . (tip - the later of both joints); its angle is straight."""
    arm, q = PlanarArm([0.6, 0.5, 0.4, 0.3]), np.array(q)
    work = AtWork(PositionTask(target, frame=frame, gain=1.0), arm)
    e, _ = work.at(q)
    S = work.plan.curvature_of(e)
    links = arm.links_to(frame)
    points = arm.points(q)
    by_hand = np.zeros((4, 4))
    for a in range(links):
        for b in range(links):
            by_hand[a, b] = -e @ (points[links] - points[max(a, b)])
    np.testing.assert_allclose(S, by_hand, atol=1e-12 * (1.0 + np.abs(e).max()))
    assert not AtWork(OrientationTask(0.3, frame=frame, gain=1.0), arm).bend(q, [2.0]).any()


# What holds for all parts.


#: Whose rows bend, and whose matrix says nothing of it: measured in Python, or of what is no value of a frame.
UNTOLD = ("Height", "Abscissa", "Ordinate", "Biased", "DistanceLimit", "AvoidanceTask", "SelfCollisionLimit")
UNTOLD += ("CollisionLimit", "RollingTask", "OmniwheelTask")
SPEEDS = ("FrameVelocityLimit",)
#: Rows that are taken from other states, or that do not come from a value.
OTHER = (
    "ManipulabilityTask",
    "DynamicManipulabilityTask",
    "MinorAxisTask",
    "VelocityRatioTask",
    "MinimumTorqueTask",
    "JointTorqueLimit",
)
OTHER += ("Stretched", "KineticEnergyTask", "JointCentringTask", "MinimumMotionTask")


@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("robot", SETTINGS)
def test_a_part_tells_how_it_bends_or_is_straight_or_is_named_here(robot, group):
    setting = SETTINGS[robot]()
    for case in GROUPS[group](setting):
        part = case.spec.make({}, lambda kind: kind, {})
        if not part.plain and "velocity" in case.orders:  # plain rows are those of the identity
            check_tells(part, setting)


def check_tells(part, setting):
    robot, q, rows = setting.robot, setting.states[0][0], part.size(setting.robot)
    work = AtWork(part, robot, 0.3)
    if work.plan.curvature is not None:
        S, w = work.bend(q, np.ones(rows)), np.linspace(-1.0, 1.0, rows)
        assert np.isfinite(S).all()
        assert np.array_equal(S, S.T)
        assert not work.bend(q, np.zeros(rows)).any()
        both = work.bend(q, 1.0 - 2.0 * w)
        np.testing.assert_allclose(both, S - 2.0 * work.bend(q, w), atol=1e-12 * (1.0 + np.abs(S).max()))
    elif not {type(getattr(part, "task", part)).__name__, type(part).__name__} & {*UNTOLD, *SPEEDS, *OTHER}:
        now, there = (work.at(at)[1] for at in (q, q + 0.1))
        np.testing.assert_array_equal(now, there, err_msg=f"{part!r} bends, and does not tell")


def test_an_inequality_bends_as_its_task_and_a_joint_motion_not_at_all():
    robot = robot_named("panda")
    rng = np.random.default_rng(2)
    q, w = robot.random(rng), rng.normal(size=3)
    task = PositionTask([0.4, 0.2, 0.5], gain=1.0)
    own = AtWork(task, robot).bend(q, w)
    for kind in AtLeast, AtMost, lambda task: Within(task, 0.1):
        np.testing.assert_array_equal(AtWork(kind(task), robot).bend(q, w), own)
    assert AtWork(JointMotion(task), robot).plan.curvature is None


def test_it_adds_to_what_is_there_wherever_it_is_told_to():
    robot, rng = robot_named("panda"), np.random.default_rng(4)
    work, w = AtWork(PositionTask([0.4, 0.2, 0.5], gain=1.0), robot), rng.normal(size=3)
    S = work.bend(robot.random(rng), w)
    call = work.plan.curvature
    total, weights = np.ones((robot.nv, robot.nv)), 2.0 * w
    call.table.numbers[:2] = weights.ctypes.data, total.ctypes.data
    call.run()
    np.testing.assert_allclose(total, 1.0 + 2.0 * S, atol=1e-14)
    np.testing.assert_array_equal(work.plan.curvature_of(w), S)


@pytest.mark.parametrize("order", ["velocity", "acceleration", "displacement"])
def test_it_is_the_same_at_every_order(order):
    robot, rng = robot_named("g1"), np.random.default_rng(4)
    q, w = robot.random(rng), rng.normal(size=3)
    task = CenterOfMassTask([0.0, 0.1, 0.6], gain=1.0)
    np.testing.assert_array_equal(AtWork(task, robot, order=order).bend(q, w), AtWork(task, robot).bend(q, w))


class Told:
    """A robot of one's own, that tells which joint carries which, or does not."""

    nq = nv = 4

    def __init__(self, arm):
        self._arm = arm

    def at(self, q, v):
        return self._arm.at(q, v)


class Ordered(Told):
    def chain_order(self, frame, relative_to=None):
        return self._arm.chain_order(frame, relative_to)


def test_robots_of_ones_own_bend_if_they_tell_the_order_of_their_joints():
    arm, q = PlanarArm([0.6, 0.5, 0.4, 0.3]), np.array([0.3, 0.7, -0.4, 0.5])
    task = PositionTask([0.4, 0.9], gain=1.0)
    np.testing.assert_allclose(AtWork(task, Ordered(arm)).bend(q, [1.0, 2.0]), AtWork(task, arm).bend(q, [1.0, 2.0]))
    silent = AtWork(task, Told(arm)).plan
    assert silent.curvature is None
    with pytest.raises(InvalidInput, match="no curvature"):
        silent.curvature_of([1.0, 2.0])
    with pytest.raises(InvalidInput, match=r"weights has shape \(3,\)"):
        AtWork(task, arm).plan.curvature_of([1.0, 2.0, 3.0])


def test_pairs_are_told_once_with_what_carries_first():
    pairs = [[0, 0, 0], [0, 3, 1], [2, 0, 0], [2, 2, 0], [2, 3, 0], [3, 3, 0]]
    assert carried(np.array([1, APART, 0, 1])).tolist() == pairs


TREE = np.array([[0, APART, APART, APART], [0, 1, APART, APART], [0, APART, 1, 1], [0, APART, 1, 1]])


@pytest.mark.parametrize(
    ("pairs", "chain", "velocities"),
    [
        (carried(np.array([1, APART, 0, 1])), [[-1, 0, 1], [0, 1, 3]], [2, 0, 3]),
        (carried_in_tree(TREE), [[-1, 0, 1], [0, 1, 2], [0, 2, 4]], [0, 1, 2, 3]),
        (carried(np.array([APART, APART])), [], []),
    ],
    ids=["a joint with two velocities", "two branches", "none"],
)
def test_joints_come_after_those_that_carry_them(pairs, chain, velocities):
    found = joint_by_joint(pairs)
    assert [each.tolist() for each in found] == [chain, velocities]
    assert found[0].shape == (len(chain), 3)
