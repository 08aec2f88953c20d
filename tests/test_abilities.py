"""Robots of one's own: each ability alone gives what it says, and a namesake is refused by its name."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hqp import InvalidInput
from hqp.guard import Guard
from tasks import (
    CenterOfMassTask,
    Controller,
    Damping,
    Freeze,
    JointCentringTask,
    JointLimits,
    JointTorqueLimit,
    JointVelocityLimit,
    JointVelocityTask,
    KineticEnergyTask,
    MinimumMotionTask,
    MinimumTorqueTask,
    Part,
    PlanarArm,
    PositionTask,
    PostureTask,
    Stack,
    simulate,
    solve_ik,
)
from tasks.robots import abilities as able
from tasks.robots import robot as ask
from tasks.robots.frame import FixedFrame
from tasks.robots.loading import load_robot
from tasks.robots.skeleton import skeleton

ARM = PlanarArm([0.5, 0.4, 0.3])
Q, REST = np.array([0.4, 0.9, 0.6]), np.zeros(3)
HELD = JointVelocityLimit(3.0)


class Bare:
    """An arm that can do nothing but tell its state, and has names that mean nothing here."""

    nq = nv = 3
    model, data, kind, robot, joints = "R3", [1, 2], "arm", "left", 3

    def at(self, q, v):
        return ARM.at(q, v)

    def __repr__(self):
        return "Bare()"


def with_(**attributes):
    """A bare robot with these attributes."""
    robot = Bare()
    for name, value in attributes.items():
        setattr(robot, name, value)
    return robot


class State:
    """A state of the arm with these attributes, and no others than every state has."""

    def __init__(self, q, v, **attributes):
        self.q, self.v, self._arm = q, v, ARM.at(q[:3], v)
        self.__dict__.update(attributes)

    def frame(self, name=None):
        return self._arm.frame(name)


def telling(**attributes):
    """A bare robot whose states have these attributes."""
    return with_(at=lambda q, v: State(q, v, **attributes))


def velocity(robot):
    return Controller(robot, HELD >> PositionTask([0.5, 0.3], gain=2.0), dt=0.01, damping=None)(Q, REST).v


# What there is of them.


def test_a_bare_robot_has_no_ability_and_is_driven():
    robot = Bare()
    assert ask.as_robot(robot) is robot
    assert ask.abilities(robot) == frozenset()
    assert ask.state_abilities(telling().at(Q, REST)) == frozenset()
    assert not ask.on_pinocchio(robot)
    np.testing.assert_array_equal(ask.neutral(robot), np.zeros(3))
    np.testing.assert_array_equal(ask.home(robot), np.zeros(3))
    assert ask.base(robot) == 0
    assert ask.joint_names(robot) == ("joint 0", "joint 1", "joint 2")
    assert ask.joint_units(robot) == ("rad", "rad", "rad")
    assert ask.frame_names(robot) == ()
    assert ask.has_frame(robot, "whatever")
    assert ask.tip(robot) is None
    assert not ask.tells_tip(robot)
    for quantity in "position", "velocity", "acceleration", "torque":
        assert ask.limit_of(robot, quantity) is None
    for method in ask.mass_matrix, ask.bias, ask.inverse_dynamics, ask.manipulability, ask.points, ask.workspace:
        assert method(robot) is None
    np.testing.assert_allclose(velocity(robot), velocity(ARM), atol=1e-12)


def test_robots_of_this_package_declare_what_they_can():
    flat = {able.PositionLimited, able.VelocityLimited, able.AccelerationLimited, able.TorqueLimited}
    common = flat | {able.WithFrames, able.Inertial, able.MotionEquation, able.InverseDynamics}
    assert ask.abilities(ARM) == common | {able.Manipulable, able.Drawn}
    more = {able.Neutral, able.Manifold, able.Homed, able.Floating, able.Named, able.WithAliases, able.Tipped}
    robot = load_robot("ur5")
    assert ask.abilities(robot) == common | more | {able.SharedWorkspace}
    every = {able.WithJoints, able.Owned, able.Posed, able.Massive}
    assert ask.state_abilities(ask.at_rest(robot)) == every
    for own in ARM, robot, load_robot("g1"):
        ask.as_robot(own)
        ask.check_states(own)


# Each alone gives what it says.


def test_neutral_is_where_tasks_are_tried():
    robot = with_(neutral=Q)
    np.testing.assert_array_equal(ask.neutral(robot), Q)
    np.testing.assert_array_equal(ask.home(robot), Q)
    np.testing.assert_array_equal(ask.at_rest(robot).q, Q)


def test_home_is_where_inverse_kinematics_begins():
    task, there = PositionTask(ARM.pose(Q)[:2], gain=1.0), with_(home=Q)
    np.testing.assert_array_equal(ask.home(there), Q)
    np.testing.assert_array_equal(ask.neutral(there), np.zeros(3))
    np.testing.assert_allclose(solve_ik(there, task).q, Q, atol=1e-6)


class Wrapped(Bare):
    """Joints whose angles are counted from 0 to a whole turn."""

    neutral = np.ones(3)

    def integrate(self, q, step):
        return np.mod(q + step, 2.0 * np.pi)

    def difference(self, start, end):
        return np.mod(end - start + np.pi, 2.0 * np.pi) - np.pi

    def at(self, q, v):
        return State(q, v, robot=self)


def test_configurations_on_a_manifold_are_integrated_and_told_apart_by_the_robot():
    robot = Wrapped()
    assert ask.abilities(robot) == {able.Neutral, able.Manifold}
    start = np.array([0.1, 0.2, 6.2])
    np.testing.assert_allclose(ask.integrate(robot, start, np.full(3, 0.2)), [0.3, 0.4, 6.4 - 2.0 * np.pi])
    step = ask.difference(robot, start, np.array([6.2, 0.2, 0.1]))
    np.testing.assert_allclose(step, [6.1 - 2.0 * np.pi, 0.0, 2.0 * np.pi - 6.1], atol=1e-12)
    stack = HELD >> PostureTask([6.2, 0.2, 0.1], gain=2.0)
    record = simulate(Controller(robot, stack, dt=0.01, damping=None), start, duration=4.0)
    np.testing.assert_allclose(record.q[-1], [6.2, 0.2, 0.1], atol=2e-3)
    assert np.abs(np.diff(record.q[:, 0])).max() > 6.0  # across zero, the short way


def test_a_floating_base_is_left_alone():
    robot = with_(base=3, nq=3)
    assert ask.base(robot) == 3
    with pytest.raises(InvalidInput, match="has a planar base"):
        ask.check_fixed_base(robot, "torque")


class Own(Part):
    """Bounds on x itself that are nobody's but a user's."""

    plain, name = True, "own"

    def write(self, tick, A, lower, upper):
        lower[:] = upper[:] = 0.0


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize(
    "part",
    [
        Damping(0.1), MinimumMotionTask(gain=1.0), JointVelocityTask([0.0] * 3), Freeze([0, 1, 2]), Own(),
        PostureTask([0.1] * 3, gain=1.0), JointCentringTask(gain=1.0), JointVelocityLimit(1.0),
    ],
    ids=lambda part: type(part).__name__ if isinstance(part, Part) else part,
)  # fmt: skip
def test_rows_on_joints_are_told_in_the_units_of_the_joints(part, order):
    """A row that bounds x itself is a joint: an explanation says which, and by how many m/s or rad/s it is short."""
    named = with_(joint_names=["a", "b", "lift"], joint_units=["rad", "rad", "m"])
    named.position_limit = -np.ones(3), np.ones(3)
    robot = ask.as_robot(named)
    per = {"velocity": "/s", "acceleration": "/s^2"}[order]
    assert [(label.row.split()[0], label.unit) for label in part.labels(robot, order)] == [
        ("a", f"rad{per}"), ("b", f"rad{per}"), ("lift", f"m{per}"),
    ]  # fmt: skip


def test_joints_go_by_their_names():
    robot = with_(joint_names=["a", "b", "lift"], joint_units=["rad", "rad", "m"])
    labels = JointVelocityLimit(1.0).labels(ask.as_robot(robot), "velocity")
    assert [(label.row, label.unit) for label in labels] == [("a", "rad/s"), ("b", "rad/s"), ("lift", "m/s")]
    with pytest.raises(InvalidInput, match="did you mean 'lift'"):
        Controller(robot, PostureTask([0.1], joints=["lift "], gain=1.0), damping=None)


def test_frames_that_are_none_are_refused_where_they_are_listed():
    listed = with_(frame_names=["tip", "link1"])
    ask.check_frame(listed, "link1", "frame")
    with pytest.raises(InvalidInput, match=r"frame 'link' is no frame of .*did you mean 'link1'"):
        ask.check_frame(listed, "link", "frame")
    ask.check_frame(with_(frame_names=["tip"], has_frame=lambda name: name == "body:tip"), "body:tip", "frame")
    with pytest.raises(InvalidInput, match="has no tip"):
        Controller(with_(tip=None), PositionTask([0.5, 0.3], gain=1.0), damping=None)


@pytest.mark.parametrize("quantity", ["velocity", "acceleration", "torque"])
def test_limits_of_its_own_count_one_by_one(quantity):
    robot = with_(**{f"{quantity}_limit": np.array([1.0, np.inf, 2.0])})
    np.testing.assert_array_equal(ask.limit_of(ask.as_robot(robot), quantity), [1.0, np.inf, 2.0])
    others = {"position", "velocity", "acceleration", "torque"} - {quantity}
    assert all(ask.limit_of(robot, other) is None for other in others)
    if quantity == "velocity":
        assert (
            np.abs(
                Controller(robot, JointLimits() >> PositionTask([-9.0, 9.0], gain=9.0), dt=0.1, damping=None)(
                    Q, REST
                ).v[0]
            )
            <= 1.0
        )


def test_a_range_of_its_own_is_kept():
    robot = with_(position_limit=np.array([[-1.0, -1.0, -np.inf], [1.0, 1.0, np.inf]]))
    ask.as_robot(robot)
    assert solve_ik(robot, PositionTask([-0.9, 0.0], gain=1.0), Q).q[0] <= 1.0 + 1e-9


def test_a_mass_matrix_and_a_bias_are_asked_for_apart():
    inertial = with_(mass_matrix=ARM.mass_matrix)
    assert ask.abilities(inertial) == {able.Inertial}
    assert Controller(inertial, HELD >> KineticEnergyTask(), dt=0.01, damping=None)(Q, REST).ok
    ask.check_mass_matrix(inertial, "energy")
    with pytest.raises(InvalidInput, match=r"no bias"):
        Controller(inertial, JointTorqueLimit(9.0), order="acceleration", dt=0.01, damping=None)
    dynamic = with_(mass_matrix=ARM.mass_matrix, bias=ARM.bias)
    ask.check_dynamics(dynamic, "torque")
    assert Controller(dynamic, MinimumTorqueTask(), order="acceleration", dt=0.01, damping=None)(Q, REST).ok
    with pytest.raises(InvalidInput, match=r"bias\(q, v\) of Bare\(\) gives shape \(2,\); it must be \(3,\)"):
        ask.check_dynamics(with_(mass_matrix=ARM.mass_matrix, bias=lambda q, v: np.zeros(2)), "torque")
    with pytest.raises(InvalidInput, match=r"torque: takes .* has no mass_matrix\(q\)"):
        ask.check_dynamics(with_(bias=[0.1, 0.2, 0.3]), "torque")  # of a sensor


def test_records_tell_what_the_robot_tells():
    robot = with_(inverse_dynamics=ARM.inverse_dynamics, manipulability=ARM.manipulability)
    record = simulate(
        Controller(robot, HELD >> PositionTask([0.5, 0.3], gain=2.0), dt=0.01, damping=None), Q, duration=0.05
    )
    np.testing.assert_allclose(record.manipulability, ARM.manipulability(record.q))
    np.testing.assert_allclose(record.tau, ARM.inverse_dynamics(record.q[:-1], record.v[:-1], record.a))


@pytest.mark.parametrize("dimensions", [2, 3])
def test_points_are_drawn(dimensions):
    robot = with_(points=lambda q: np.pad(ARM.points(q), ((0, 0), (0, dimensions - 2))))
    np.testing.assert_array_equal(skeleton(robot, Q), skeleton(ARM, Q))


def test_a_shared_workspace_is_guarded_and_looks_at_configurations():
    class Shared(Bare):
        def __init__(self):
            self.guard = Guard("the workspace")

        def on_manifold(self, q):
            return q, None if q[0] < 1.0 else "beyond one turn"

        def state(self, q, v):
            return ARM.at(q, v)

    robot = Shared()
    controller = Controller(robot, HELD >> PositionTask([0.5, 0.3], gain=2.0), dt=0.01, damping=None)
    assert controller(Q, REST).ok
    assert controller(Q + 1.0, REST).solution.message == "beyond one turn"
    with robot.guard, pytest.raises(Exception, match="the workspace is at work for another thread"):
        controller(Q, REST)


# States.


def test_a_state_tells_joints_pose_and_whose_it_is():
    robot = telling(joints=np.array([1.0, 2.0, 3.0]), pose=np.array([7.0, 8.0]))
    ask.check_states(robot)
    state = robot.at(Q, REST)
    np.testing.assert_array_equal(ask.joint_positions(state), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(ask.joint_reader(state)(state), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(ask.pose_reader(state)(state), [7.0, 8.0])
    bare = telling().at(Q, REST)
    np.testing.assert_array_equal(ask.joint_positions(bare), Q)
    np.testing.assert_array_equal(ask.joint_reader(bare)(bare), Q)
    assert ask.pose_reader(bare)(bare).shape == (0,)
    assert ask.robot_of(bare) is None
    assert ask.robot_of(Wrapped().at(Q, REST)) is not None


def test_a_state_tells_its_centre_of_mass():
    J = np.eye(3)
    place = FixedFrame(np.array([0.1, 0.2, 0.3]), np.eye(3), J, np.zeros((3, 3)), np.zeros(3), np.zeros(3))
    assert ask.center_of_mass(telling().at(Q, REST)) is None
    robot = telling(center_of_mass=place)
    step = Controller(robot, HELD >> CenterOfMassTask([0.2, 0.2, 0.3], gain=2.0), dt=0.01, damping=None)(Q, REST)
    np.testing.assert_allclose(step.v, [0.2, 0.0, 0.0], atol=1e-12)


# Namesakes.


@pytest.mark.parametrize(
    "attributes",
    [
        {"model": object(), "data": object()},
        {"state": "idle"},
        {"guard": True},
        {"on_manifold": False},
        {"state": "idle", "guard": "open", "on_manifold": 3},
        {"points": [[0.0, 0.0]]},
        {"bias": np.array([0.1, 0.0, 0.2])},
        {"geometry": "round", "ready": False, "support": "wheels", "places": 4, "frame_index": 3, "source": "shop"},
        {"integrate": None, "difference": None, "inverse_dynamics": None},
    ],
    ids=lambda attributes: " ".join(attributes),
)
def test_names_that_mean_nothing_here_change_nothing(attributes):
    robot = with_(**attributes)
    np.testing.assert_allclose(velocity(robot), velocity(ARM), atol=1e-12)
    record = simulate(
        Controller(robot, HELD >> PositionTask([0.5, 0.3], gain=2.0), dt=0.01, damping=None), Q, duration=0.02
    )
    assert record.stopped is None
    with pytest.raises(InvalidInput):
        skeleton(robot, Q)


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"at": 3}, r"at of the robot = 3 is a int; it must be at\(q, v\)"),
        ({"neutral": "gear"}, "neutral of the robot"),
        ({"neutral": [0.0, 0.0]}, r"neutral of the robot, a configuration, has shape \(2,\); it must be \(3,\)"),
        ({"neutral": [0.0, 0.0, np.nan]}, "neutral of the robot.* must be finite"),
        ({"home": "12 High Street"}, "home of the robot"),
        ({"home": [0.0]}, r"home of the robot, a configuration, has shape \(1,\)"),
        ({"base": "base_link"}, "base of the robot = 'base_link'; it must be 0, 3 or 6"),
        ({"base": np.eye(4)}, "base of the robot = .*; it must be 0, 3 or 6"),
        ({"base": 6}, "base of the robot = 6, and the robot has 3 velocities"),
        ({"base": True}, "base of the robot = True; it must be 0, 3 or 6"),
        (
            {"integrate": True},
            "has integrate but no neutral and difference; it must have neutral, integrate, difference",
        ),
        ({"integrate": np.add, "difference": np.subtract}, "has integrate and difference but no neutral"),
        (
            {"neutral": REST, "integrate": True, "difference": np.subtract},
            r"integrate of the robot = True is a bool; it must be integrate\(q, step\)",
        ),
        (
            {"neutral": REST, "integrate": lambda f: f, "difference": np.subtract},
            r"integrate\(q, step\) of the robot, asked where it is neutral, raised TypeError",
        ),
        (
            {"neutral": REST, "integrate": lambda q, v: 0.0, "difference": np.subtract},
            r"integrate\(q, step\) of the robot, .* gives 0.0; it must be an array of shape \(3,\)",
        ),
        ({"joint_names": ["a", "b", "c"]}, "has joint_names but no joint_units"),
        ({"joint_names": "abc", "joint_units": ["rad"] * 3}, "joint_names of the robot = 'abc' is a str"),
        ({"joint_names": ["a", "b"], "joint_units": ["rad"] * 3}, "joint_names of the robot has 2; it must have 3"),
        ({"joint_names": ["a", "b", "a"], "joint_units": ["rad"] * 3}, "joint_names of the robot has 'a' twice"),
        ({"joint_names": ["a", "b", "c"], "joint_units": ["deg"] * 3}, "has 'deg'; it must be 'rad' or 'm'"),
        ({"frame_names": 3}, "frame_names of the robot = 3 is a int"),
        ({"frame_names": ["a"], "has_frame": True}, r"has_frame of the robot = True is a bool; .* has_frame\(name\)"),
        ({"tip": 0.3}, "tip of the robot = 0.3 is a float; it must be the name of a frame, or None"),
        ({"position_limit": [-1.0, 1.0]}, r"position limit of the robot, .* has shape \(2,\); it must be \(2, 3\)"),
        ({"position_limit": np.array([[1.0] * 3, [-1.0] * 3])}, "position limit of the robot: .* lowest must not be"),
        ({"velocity_limit": 3.0}, r"velocity limit of the robot, .* has shape \(\); it must be \(3,\)"),
        ({"velocity_limit": "fast"}, "velocity limit of the robot"),
        (
            {"velocity_limit": [1.0, -1.0, 1.0]},
            "velocity limit of the robot: that of 'joint 1' = -1; it must not be neg",
        ),
        ({"acceleration_limit": [1.0, 0.0, 1.0]}, "that of 'joint 1' = 0; it must be positive"),
        ({"torque_limit": [1.0, np.nan, 1.0]}, "torque limit of the robot: that of 'joint 1' = nan"),
        ({"inverse_dynamics": "no"}, r"inverse_dynamics of the robot = 'no' is a str; .* inverse_dynamics\(q, v, a\)"),
        ({"manipulability": 0.3}, r"manipulability of the robot = 0.3 is a float; it must be manipulability\(q\)"),
    ],
    ids=lambda case: " ".join(case) if isinstance(case, dict) else "",
)
def test_a_namesake_is_refused_by_its_name(attributes, message):
    robot = with_(**attributes)
    for refuse in (
        lambda: ask.as_robot(robot),
        lambda: Controller(robot, HELD, dt=0.01, damping=None),
        lambda: Stack(HELD).build(robot, "velocity", 0.01),
        lambda: solve_ik(robot, PositionTask([0.5, 0.3], gain=1.0)),
    ):
        with pytest.raises(InvalidInput, match=message):
            refuse()


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        (with_(at=lambda q, v: None), r"None, is a NoneType; a state has q, v and frame\(name\)"),
        (with_(at=lambda q, v: SimpleNamespace(q=q, v=v, frame="tip")), r"a state has q, v and frame\(name\)"),
        (with_(at=lambda q, v: State(np.zeros(4), v)), r"q of the state .* has shape \(4,\); it must be \(3,\)"),
        (telling(joints=7), r"joints of the state .* has shape \(\); it must be \(3,\)"),
        (telling(pose="upright"), "pose of the state"),
        (telling(pose=np.eye(3)), r"pose of the state .* has shape \(3, 3\); it must be \(k,\)"),
        (telling(robot="left"), "robot of the state .* = 'left'; it must be the robot whose state it is"),
        (telling(robot=PlanarArm([1.0])), "it must be the robot whose state it is"),
    ],
)
def test_states_that_mean_something_else_are_refused(robot, message):
    with pytest.raises(InvalidInput, match=message):
        ask.check_states(robot)
    with pytest.raises(InvalidInput, match=message):
        solve_ik(robot, PositionTask([0.5, 0.3], gain=1.0))


def test_states_on_a_manifold_tell_whose_they_are_and_the_joints():
    class Anonymous(Wrapped):
        def at(self, q, v):
            return State(q, v)

    with pytest.raises(InvalidInput, match="has no robot; where configurations lie on a manifold"):
        ask.check_states(Anonymous())

    class Longer(Wrapped):
        nq, neutral = 4, np.ones(4)

        def integrate(self, q, step):
            return q + np.append(step, 0.0)

        def difference(self, start, end):
            return (end - start)[:3]

    with pytest.raises(InvalidInput, match="has no joints; where nq = 4 and nv = 3 differ"):
        ask.check_states(Longer())


def test_where_a_step_leads_is_refused_if_nothing_says_so():
    robot = SimpleNamespace(nq=4, nv=3, at=ARM.at)
    with pytest.raises(InvalidInput, match=r"4 positions and 3 velocities.* integrate\(q, step\)"):
        ask.integrate(robot, np.zeros(4), np.zeros(3))
    with pytest.raises(InvalidInput, match=r"difference\(start, end\)"):
        ask.difference(robot, np.zeros(4), np.zeros(4))
