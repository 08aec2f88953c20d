"""Every task on five robots: Jacobian and drift against differences, and the two control laws with moving targets.

What a frame does is taken from Pinocchio's placements alone, and differenced: nothing here believes a Jacobian.
200 states a robot: ``python -m pytest -m sweep -k jacobians``.
"""

from __future__ import annotations

from functools import cache
from itertools import product
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from asking import asked

from tasks import (
    AxisTask,
    CenterOfMassTask,
    JointCouplingTask,
    Line,
    LinearHolonomicTask,
    LookAtTask,
    OmniwheelTask,
    OrientationTask,
    PlaneTask,
    PoseTask,
    PositionTask,
    PostureTask,
    RollingTask,
    Turn,
    load_robot,
    quintic,
)
from tasks.base.rotations import exp, log, perpendicular

#: The frame that is looked at, one that stands for the world, and two joints.
ROBOTS = {
    "panda": ("panda_hand_tcp", "panda_link3", ("panda_joint2", "panda_joint6")),
    "ur5": ("tool0", "forearm_link", ("elbow_joint", "wrist_1_joint")),
    "tiago": ("arm_tool_link", "base_link", ("torso_lift_joint", "arm_4_joint")),
    "g1": ("right_rubber_hand", "left_ankle_roll_link", ("left_knee_joint", "right_knee_joint")),
    "talos": ("gripper_left_base_link", "right_sole_link", ("leg_left_4_joint", "leg_right_4_joint")),
}
REFERENCES = ("world", "local", "local_world_aligned")
AXIS, NORMAL = np.array([1.0, 2.0, -2.0]) / 3.0, np.array([2.0, 1.0, -2.0]) / 3.0
GAIN, ZETA, DURATION, NOW = 2.0, 0.8, 2.0, 0.9
SHARE = quintic(NOW / DURATION)[0]
H = 1e-6

robots = pytest.mark.parametrize("name", ROBOTS)
orders = pytest.mark.parametrize("order", ["velocity", "acceleration"])


@cache
def robot_named(name):
    return load_robot(name, lock=["panda_finger_joint1"] if name == "panda" else ())


@cache
def scratch(robot):
    """Pinocchio's data, of our own."""
    return robot.model.createData()


def place(robot, q, frame, root):
    """Position and rotation of a frame, for an observer on `root`, by Pinocchio's placements."""
    data = scratch(robot)
    pin.framesForwardKinematics(robot.model, data, q)
    own = data.oMf[robot.model.getFrameId(frame)]
    seen = own if root is None else data.oMf[robot.model.getFrameId(root)].actInv(own)
    return seen.translation.copy(), seen.rotation.copy()


def weight(robot, q, root):
    data = scratch(robot)
    point = pin.centerOfMass(robot.model, data, q).copy()
    pin.framesForwardKinematics(robot.model, data, q)
    return point if root is None else data.oMf[robot.model.getFrameId(root)].actInv(point)


class Motion:
    """What a frame does at q while the joints move at v, by differences."""

    def __init__(self, robot, q, v, frame, root):
        (p0, R0), (p1, R1) = (place(robot, robot.integrate(q, s * H * v), frame, root) for s in (-1, 1))
        self.p, self.R = place(robot, q, frame, root)
        self.p_dot, self.omega = (p1 - p0) / (2 * H), log(R1 @ R0.T) / (2 * H)
        self.com = weight(robot, q, root)
        self.com_dot = np.subtract(*(weight(robot, robot.integrate(q, s * H * v), root) for s in (1, -1))) / (2 * H)


def passing(start, step):
    """A line that is at `start` now."""
    start, step = np.atleast_1d(start), np.atleast_1d(step)
    return Line(start - SHARE * step, start + (1.0 - SHARE) * step, DURATION, quintic)


def turning(R, vector):
    """A turn that is at R now."""
    return Turn(exp(-SHARE * vector) @ R, exp((1.0 - SHARE) * vector) @ R, DURATION)


def kinds(name):
    """Task by task: how it is made around a motion, what its rows measure, and what of its error decays by the law.

    `make(m, near, size)`: with a target that passes by at a distance of the order `size`, by random vectors `near`.
    """
    frame, root, joints = ROBOTS[name]
    found = {}

    def kind(label, make, rows, decays=lambda m, e: e, root=None, spins=False):
        found[label] = SimpleNamespace(make=make, rows=rows, decays=decays, frame=frame, root=root, spins=spins)

    for reference, seen, some in product(REFERENCES, (None, root), (False, True)):
        own = {"frame": frame, "relative_to": seen, "reference": reference, "gain": GAIN, "damping_ratio": ZETA}
        label = f"{reference}{', relative' if seen else ''}{', masked' if some else ''}"

        def turned(m, vector, reference=reference):
            return m.R.T @ vector if reference == "local" else vector

        def away(m, e, reference=reference):
            return m.R @ e if reference == "local" else e

        def turn(m, e, reference=reference):  # what stands still in the frame when both turn alike
            return e if reference == "local" else m.R.T @ e

        def pose(m, spatial=reference == "world", turned=turned):
            linear = m.p_dot + np.cross(m.p, m.omega) if spatial else m.p_dot
            return np.concatenate([turned(m, linear), turned(m, m.omega)])

        def halves(m, e, spatial=reference == "world", away=away, turn=turn):
            linear = e[:3] - np.cross(m.p, e[3:]) if spatial else e[:3]
            return np.concatenate([away(m, linear), turn(m, e[3:])])

        def position(m, near, size, own=own, mask="xz" if some else None):
            return PositionTask(passing(m.p + size * near[0], near[1]), mask=mask, **own)

        def orientation(m, near, size, own=own, mask="yz" if some else None):
            return OrientationTask(turning(exp(size * near[2]) @ m.R, near[3]), mask=mask, **own)

        def both(m, near, size, own=own, mask="y z rx rz" if some else None):
            path = passing(m.p + size * near[0], near[1])
            return PoseTask(path, turning(exp(size * near[2]) @ m.R, near[3]), mask=mask, **own)

        rows = [0, 2] if some else [0, 1, 2]
        kind(
            f"position, {label}",
            position,
            lambda m, t=turned, rows=rows: t(m, m.p_dot)[rows],
            None if some and reference == "local" else (lambda m, e, a=away: e if len(e) < 3 else a(m, e)),
            seen,
        )
        rows = [1, 2] if some else [0, 1, 2]
        decays = None if some else turn
        kind(f"orientation, {label}", orientation, lambda m, t=turned, rows=rows: t(m, m.omega)[rows], decays, seen)
        rows = [1, 2, 3, 5] if some else list(range(6))
        decays = None if some else halves
        kind(f"pose, {label}", both, lambda m, p=pose, rows=rows: p(m)[rows], decays, seen)

    for seen in (None, root):
        own = {"frame": frame, "relative_to": seen, "gain": GAIN, "damping_ratio": ZETA}
        label = ", relative" if seen else ""

        def direction(m, near, size, own=own):
            return AxisTask(passing(m.R @ AXIS + size * near[0], near[1]), axis=AXIS, **own)

        def point(m, near, size, own=own):
            return LookAtTask(passing(m.p + 0.8 * (m.R @ AXIS) + size * near[0], near[1]), axis=AXIS, **own)

        def plane(m, near, size, own=own):
            return PlaneTask(3.0 * NORMAL, passing(NORMAL @ m.p + size * near[0][0], near[1][0]), **own)

        def com(m, near, size, seen=seen):
            path = passing(m.com + size * near[0], near[1])
            return CenterOfMassTask(path, relative_to=seen, gain=GAIN, damping_ratio=ZETA)

        def across(m, task):
            return task._across @ m.R.T

        def sight(m, task):
            ray = task.target(NOW)[0] - m.p
            return across(m, task) @ (m.omega + np.cross(ray, m.p_dot) / (ray @ ray))

        kind(f"axis{label}", direction, lambda m, k=across: k(m, m.task) @ m.omega, root=seen, spins=True)
        kind(f"look at{label}", point, lambda m, k=sight: k(m, m.task), root=seen, spins=True)
        kind(f"plane{label}", plane, lambda m: NORMAL @ m.p_dot[:, None], root=seen)
        kind(f"center of mass{label}", com, lambda m: m.com_dot, root=seen)

        def slip(m, radius=0.2):  # of what touches the plane
            return m.p_dot + np.cross(m.omega, -radius * NORMAL)

        def rolls(m, near, size, own=own):
            return RollingTask(0.2, normal=3.0 * NORMAL, floor=0.1, **own)

        def drives(m, near, size, own=own):
            return OmniwheelTask(0.2, axle=AXIS, rollers=0.6, normal=3.0 * NORMAL, floor=0.1, **own)

        def driven(m, slip=slip):
            ahead = np.cross(m.R @ AXIS, NORMAL)
            ahead = exp(0.6 * NORMAL) @ (ahead / np.linalg.norm(ahead))
            return np.array([ahead @ slip(m), NORMAL @ m.p_dot])

        plane_of = np.vstack([perpendicular(NORMAL), NORMAL])
        kind(f"rolling{label}", rolls, lambda m, P=plane_of, slip=slip: P @ slip(m), None, seen)
        kind(f"omniwheel{label}", drives, driven, None, seen)

    law = {"gain": GAIN, "damping_ratio": ZETA}

    def linear(m, near, size):
        columns = [list(m.joints).index(joint) for joint in joints]
        A = np.zeros((2, len(m.joints)))
        A[:, columns] = [[2.0, -1.0], [0.5, 1.0]]
        start = robot_named(name).neutral
        way = [
            m.joints[joint] - robot_named(name).at(start).joints[c] for joint, c in zip(joints, columns, strict=True)
        ]
        return LinearHolonomicTask(A, passing(A[:, columns] @ way + size * near[0][:2], near[1][:2]), **law)

    def coupling(m, near, size):
        value = 2.0 * m.joints[joints[0]] - m.joints[joints[1]]
        path = passing(value + size * near[0][0], near[1][0])
        return JointCouplingTask({joints[0]: 2.0, joints[1]: -1.0}, path, gain=GAIN, damping_ratio=ZETA)

    def named(m, near, size):
        path = passing([m.joints[joint] + size * x for joint, x in zip(joints, near[0], strict=False)], near[1][:2])
        return PostureTask(path, joints=joints, gain=GAIN, damping_ratio=ZETA)

    rates = np.array([[2.0, -1.0], [0.5, 1.0]])
    kind("linear", linear, lambda m: rates @ [m.rate(joint) for joint in joints])
    kind("coupling", coupling, lambda m: np.array([2.0 * m.rate(joints[0]) - m.rate(joints[1])]))
    kind("posture of named joints", named, lambda m: np.array([m.rate(joint) for joint in joints]))
    return found


def motion(robot, q, v, kind):
    m = Motion(robot, q, v, kind.frame, kind.root)
    columns = dict(zip(robot.joint_names, range(robot.nv), strict=True))
    state = robot.at(q, v)
    m.joints = {joint: state.joints[column] for joint, column in columns.items()}
    m.rate = lambda joint: v[columns[joint]]
    return m


def around(rng, robot, kind, size):
    """A random state, and a task whose target passes by there."""
    q, v = robot.random(rng), rng.uniform(-0.8, 0.8, robot.nv)
    m = motion(robot, q, v, kind)
    m.task = kind.make(m, rng.uniform(-0.4, 0.4, (4, 3)), size)
    return q, v, m


def check_derivatives(name, seed):
    robot, rng = robot_named(name), np.random.default_rng(seed)
    for label, kind in kinds(name).items():
        q, v, m = around(rng, robot, kind, 0.3)
        task, still = m.task, isinstance(m.task, LookAtTask)
        at = (NOW,) if still else ()
        J = task.jacobian(robot.at(q, v), *at)
        np.testing.assert_allclose(J @ v, kind.rows(m), atol=2e-8, rtol=2e-8, err_msg=f"{name}: J of {label}")
        after, before = (task.jacobian(robot.at(robot.integrate(q, s * H * v), v), *at) @ v for s in (1, -1))
        drift = np.broadcast_to(task.drift(robot.at(q, v), *at), len(J))
        np.testing.assert_allclose(
            (after - before) / (2 * H), drift, atol=2e-7, rtol=1e-7, err_msg=f"{name}: drift of {label}"
        )
        # Nothing but the derivative along v was needed: the Jacobian does not know it.
        np.testing.assert_array_equal(J, task.jacobian(robot.at(q, np.zeros(robot.nv)), *at))


def spinless(robot, q, task, J):
    """The rows of a task, and where an axis may spin, that one too."""
    frame = task.seen(robot.at(q, np.zeros(robot.nv)))
    return np.vstack([J, (frame.rotation @ task.axis) @ frame.angular])


def check_law(name, order, seed):
    """Whatever moves: the error of a task that is obeyed decays as Eq. 4.5 and 4.7 have it."""
    robot, rng = robot_named(name), np.random.default_rng(seed)
    checked = 0
    for label, kind in kinds(name).items():
        if kind.decays is None:  # some rows of axes that turn: they feed on each other
            continue
        size, h = (0.3, 1e-6) if order == "velocity" else (1e-4, 1e-4)
        q, v, m = around(rng, robot, kind, size)
        task = m.task
        state = robot.at(q, v)
        J, target = asked(task, state, NOW, order)
        rows = spinless(robot, q, task, J) if kind.spins else J
        if np.linalg.svd(rows, compute_uv=False)[-1] < 0.05:
            continue  # an arm of six joints near a singularity
        if order == "velocity":
            v = v + np.linalg.pinv(J) @ (target - J @ v)
            a = np.zeros(robot.nv)
        else:  # nearly as fast as the target
            rate = np.append(task.rates(state, NOW)[0], 0.0)[: len(rows)] + size * rng.uniform(-1, 1, len(rows))
            if kind.spins:
                rate[-1] = 0.0
            v = v + np.linalg.pinv(rows) @ (rate - rows @ v)
            state = robot.at(q, v)
            _, target = asked(task, state, NOW, order)
            if kind.spins:  # and keep it from spinning
                frame = task.seen(state)
                target = np.append(target, -(frame.rotation @ task.axis) @ frame.angular_drift)
            a = np.linalg.pinv(rows) @ target
        errors = []
        for s in (-h, 0.0, h):
            there = robot.integrate(q, s * v + 0.5 * s * s * a)
            e = task.error(robot.at(there, v), NOW + s)
            if kind.spins and order == "velocity":
                e = np.linalg.norm(e)  # its two numbers turn into each other while the frame spins about the axis
            p, R = place(robot, there, kind.frame, kind.root)
            errors.append(kind.decays(SimpleNamespace(p=p, R=R), e))
        before, now, after = errors
        rate, message = (after - before) / (2 * h), f"{name}: {label}"
        if order == "velocity":
            np.testing.assert_allclose(rate, -GAIN * now, atol=3e-8, err_msg=message)
        else:
            bend = (after - 2.0 * now + before) / h**2
            law = bend + 2 * ZETA * GAIN * rate + GAIN**2 * now
            scale = 1.0 + np.abs(a).max() + np.abs(v).max() ** 2
            assert np.abs(law).max() < 2e-6 * scale, f"{message}: {law}"
        checked += 1
    return checked


@robots
@pytest.mark.parametrize("seed", range(5))
def test_rows_are_what_they_measure_and_drift_is_how_they_change(name, seed):
    check_derivatives(name, seed)


@orders
@robots
def test_errors_decay_by_the_law_while_targets_move(name, order):
    assert sum(check_law(name, order, seed) for seed in range(5)) > 60


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@robots
def test_it_does_not_matter_along_which_axes_a_whole_task_is_written(name, order):
    """Position, orientation and pose ask for the same motion in all references, of a moving frame and target."""
    robot, rng, (frame, root, _) = robot_named(name), np.random.default_rng(3), ROBOTS[name]
    own = {"frame": frame, "relative_to": root, "gain": GAIN, "damping_ratio": ZETA}
    for _ in range(3):
        state = robot.at(robot.random(rng), rng.uniform(-0.8, 0.8, robot.nv))
        seen = PositionTask([0.0, 0.0, 0.0], frame=frame, relative_to=root, gain=1.0).seen(state)
        to = passing(seen.position + 0.1, rng.uniform(-0.4, 0.4, 3))
        turn = turning(exp([0.3, -0.2, 0.1]) @ seen.rotation, rng.uniform(-0.4, 0.4, 3))
        for make in (
            lambda r, to=to: PositionTask(to, reference=r, **own),
            lambda r, turn=turn: OrientationTask(turn, reference=r, **own),
            lambda r, to=to, turn=turn: PoseTask(to, turn, reference=r, **own),
        ):
            rows = [asked(make(reference), state, NOW, order) for reference in REFERENCES]
            if np.linalg.svd(rows[0][0], compute_uv=False)[-1] < 0.05:
                continue
            motions = [np.linalg.pinv(J) @ h for J, h in rows]
            np.testing.assert_allclose(motions[1:], [motions[0]] * 2, rtol=1e-9, atol=1e-9)


@robots
def test_a_whole_posture_is_reached_along_the_shortest_way_of_every_joint(name):
    """Wheels on a circle included, and a floating base left alone: its error falls as fast as the joints move."""
    robot, rng = robot_named(name), np.random.default_rng(1)
    for _ in range(5):
        target, q, v = robot.random(rng), robot.random(rng), rng.uniform(-0.8, 0.8, robot.nv)
        task = PostureTask(target, gain=GAIN)
        task.check(robot, "acceleration", None)
        assert task.size(robot) == robot.nv - robot.base
        after, before = (task.error(robot.at(robot.integrate(q, s * H * v), v), 0.0) for s in (1, -1))
        np.testing.assert_allclose((after - before) / (2 * H), -v[robot.base :], atol=1e-8)
        np.testing.assert_array_equal(task.jacobian(robot.at(q, v)), np.eye(robot.nv)[robot.base :])
        steps = np.zeros(robot.nv)
        steps[robot.base :] = task.error(robot.at(q, v), 0.0)
        joints = slice(7 if robot.base else 0, None)
        np.testing.assert_allclose(robot.integrate(q, steps)[joints], target[joints], atol=1e-12)


@pytest.mark.sweep
@robots
@pytest.mark.parametrize("first", range(0, 200, 50))
def test_200_states_have_the_rows_that_they_should(name, first):
    for seed in range(first, first + 50):
        check_derivatives(name, seed)
        for order in "velocity", "acceleration":
            check_law(name, order, seed)
