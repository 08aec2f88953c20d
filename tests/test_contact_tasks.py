"""Tasks of forces, momentum and balance: what they ask for is what the robot then does."""

from __future__ import annotations

import numpy as np
import pytest
from contact_scenes import DT, FEET, Scene, advanced, g1, humanoid, moved, quadruped, talos

from hqp import InvalidInput
from tasks import (
    AtMost,
    CapturePointTask,
    CenterOfMassTask,
    CenterOfPressureTask,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    MinimumMotionTask,
    MomentumTask,
    OrientationTask,
    PinocchioRobot,
    PlanarArm,
    PositionTask,
    PostureTask,
    Setpoint,
    SupportLimit,
    TorqueTask,
    load_robot,
)

GRAVITY = 9.81


def stepped(scene: Scene, task, seed: int = 0):
    """One step of a stack with this task below the limits, at a state near that of standing."""
    controller = Controller(scene.robot, scene.limits >> task >> scene.rest(), order="torque", dt=DT, damping=None)
    q, v = moved(scene, seed, 0.05) if seed else (scene.q, scene.v)
    step = controller(q, v)
    assert step.ok
    assert step.solution.certify().ok
    return q, v, step


@pytest.mark.parametrize(("kind", "rows"), [("linear", slice(0, 3)), ("angular", slice(3, 6)), ("both", slice(0, 6))])
def test_momentum_follows_its_target(kind, rows) -> None:
    scene, small, gain = humanoid(), 1e-6, 3.0
    target = 0.1 * np.arange(1.0, 7.0)[rows]
    q, v, step = stepped(scene, MomentumTask(target, kind=kind, gain=gain), 1)
    after = scene.robot.integrate(q, small * (v + 0.5 * small * step.a)), v + small * step.a
    now, then = (scene.robot.momentum(*state)[rows] for state in ((q, v), after))
    assert np.allclose((then - now) / small, gain * (target - now), atol=1e-3)
    task = MomentumTask(target, kind=kind, gain=gain)
    assert np.allclose(task.error(scene.robot.at(q, v), 0.0), target - now)


def test_momentum_is_bounded_as_any_task() -> None:
    scene = humanoid()
    task = MomentumTask(np.zeros(3), kind="linear", gain=5.0)
    push = CenterOfMassTask(scene.com + np.array([0.0, 0.1, 0.0]), gain=5.0)
    q, v, step = stepped(scene, AtMost(task) >> push)
    assert (scene.robot.at(q, v).center_of_mass.linear @ step.a).max() < 1e-7


def test_the_capture_point_goes_to_its_place() -> None:
    scene, gain = humanoid(), 3.0
    target = scene.com[:2] + np.array([0.03, -0.02])
    q, v, step = stepped(scene, CapturePointTask(target, gain=gain), 2)
    state = scene.robot.at(q, v)
    c = state.center_of_mass
    soles = [state.frame(f).position + state.frame(f).rotation @ p for f in FEET for p in scene.feet[0].shape.points]
    omega = np.sqrt(GRAVITY / (c.position[2] - np.mean(soles, axis=0)[2]))
    speed, acceleration = c.linear @ v, c.linear @ step.a + c.linear_drift
    point, rate = (c.position + speed / omega)[:2], (speed + acceleration / omega)[:2]
    assert np.allclose(rate, gain * (target - point), atol=1e-8)


def test_forces_have_their_sum_and_their_place() -> None:
    scene = humanoid()
    left, right = scene.feet
    _, _, step = stepped(scene, ForceTask([5.0, -3.0, 150.0], contact=left))
    # The axes of a floor are those of the world.
    assert np.allclose(step.forces["left"].sum(axis=0), [5.0, -3.0, 150.0])
    goal = Setpoint([0.05, 0.01])
    com = CenterOfMassTask(scene.com, gain=5.0)
    _, _, step = stepped(scene, CenterOfPressureTask(goal, right) >> com)
    assert np.allclose(step.cop["right"], [0.05, 0.01, -0.03], atol=1e-6)
    wrench = humanoid(rectangle=True, wrench=True)
    _, _, step = stepped(wrench, CenterOfPressureTask(goal, wrench.feet[1]) >> CenterOfMassTask(scene.com, gain=5.0))
    assert np.allclose(step.cop["right"], [0.05, 0.01, -0.03], atol=1e-6)


def test_torques_have_their_values() -> None:
    scene = humanoid()
    wanted = np.zeros(29)
    wanted[12] = 3.0
    weight = np.zeros(29)
    weight[12] = 1.0
    _, _, step = stepped(scene, TorqueTask(wanted, weight=weight))
    assert np.isclose(step.tau[12], 3.0)
    least = Controller(
        scene.robot,
        scene.limits >> TorqueTask() + MinimumMotionTask(1e-3, gain=5.0),
        order="torque",
        dt=DT,
        damping=None,
    )
    other = Controller(scene.robot, scene.limits >> scene.rest(), order="torque", dt=DT, damping=None)
    norms = [np.linalg.norm(controller(scene.q, scene.v).tau) for controller in (least, other)]
    assert norms[0] < norms[1]


def test_motors_give_less_the_faster_they_turn() -> None:
    robot = load_robot("panda", lock=["panda_finger_joint1"])
    limit = JointTorqueLimit(80.0, speeds=(1.0, 3.0))
    rows = (limit >> PostureTask(robot.home, gain=1.0)).build(robot, "acceleration", DT)
    v = np.array([0.5, 2.0, -2.0, 5.0, -5.0, 0.0, -0.5])
    filled = rows.fill(robot.at(robot.home, v), 0.0)
    bias = robot.bias(robot.home, v)
    assert np.allclose(filled.upper[:7] + bias, 80.0 * np.array([1.0, 0.5, 1.0, 0.0, 1.0, 1.0, 1.0]))
    assert np.allclose(filled.lower[:7] + bias, -80.0 * np.array([1.0, 1.0, 0.5, 1.0, 0.0, 1.0, 1.0]))
    with pytest.raises(ValueError, match="the first must be below the second"):
        limit.speeds = (2.0, 1.0)


def test_least_forces_share_the_weight() -> None:
    scene = humanoid()
    _, _, step = stepped(scene, CenterOfMassTask(scene.com, gain=5.0))
    weight = GRAVITY * scene.robot.mass_matrix(scene.q)[0, 0]
    total = sum(step.forces[name][:, 2].sum() for name in step.forces)
    assert np.isclose(total, weight, rtol=1e-6)
    left, right = (step.forces.normal(name).sum() for name in ("left", "right"))
    assert abs(left - right) < 0.01 * weight


@pytest.mark.parametrize(
    ("make", "pelvis", "way"),
    [
        *((humanoid, "pelvis", way) for way in [(0.12, 0.0), (0.3, 0.0), (-0.3, 0.0), (0.0, 0.3)]),
        (talos, "base_link", (0.3, 0.0)),
        *(pytest.param(talos, "base_link", way, marks=pytest.mark.sweep) for way in [(0.12, 0.0), (0.0, 0.3)]),
    ],
)
def test_with_the_support_polygon_a_robot_stands(make, pelvis, way) -> None:
    """A target that none can reach: all limits are kept, the robot comes to rest, and the polygon is named."""
    scene = make()
    target = scene.com + np.array([*way, 0.0])
    reach = CenterOfMassTask(target[:2], mask="xy", gain=4.0)
    stack = scene.limits >> SupportLimit(0.01) >> reach >> scene.rest(pelvis)
    controller, q, v = Controller(scene.robot, stack, order="torque", dt=4e-3, damping=None), scene.q, scene.v
    for k in range(750):
        step = controller(q, v, 4e-3 * k)
        assert step.ok or step.solution.certify().ok  # a tick in a thousand stalls at the optimum, and says so
        assert (np.abs(step.tau) - scene.robot.torque_limit[6:]).max() < 1e-9
        for name in step.forces:
            f = step.forces[name]
            assert (np.hypot(f[:, 0], f[:, 1]) - 0.6 * f[:, 2]).max() < 1e-9
        q, v = advanced(scene.robot, q, v, step.a, 4e-3)
    state = scene.robot.at(q, v)
    c = state.center_of_mass
    assert np.linalg.norm(c.linear @ v) < 0.02
    soles = [(state.frame(foot.frame), foot.shape.points) for foot in scene.feet]
    corners = np.concatenate([sole.position + points @ sole.rotation.T for sole, points in soles])
    low, high = np.min(corners, axis=0)[:2], np.max(corners, axis=0)[:2]
    assert (c.position[:2] > low).all()
    assert (c.position[:2] < high).all()
    assert step.solution.certify().ok
    told = str(step.solution.explain())
    assert "center of mass short by" in told
    assert "support polygon" in told.split("center of mass short by")[1].splitlines()[0]


@pytest.mark.parametrize("points", [1, 2])
def test_a_support_that_is_a_point_or_a_line(points: int) -> None:
    scene = humanoid()
    place = {"centre": (0.0, 0.0, -0.03)} if points == 1 else {"line": 0.1, "centre": (0.0, 0.0, -0.03)}
    foot = Contact(FEET[0], friction=0.6, name="left", **place)
    stack = Dynamics() + foot >> SupportLimit() >> PostureTask(scene.q, gain=4.0)
    controller = Controller(scene.robot, stack, order="torque", dt=DT, damping=None)
    step = controller(scene.q, scene.v)
    assert step.ok
    rows = controller.hierarchy.levels[3]
    assert np.isfinite(rows.upper).sum() == 4  # its two sides, and its ends
    controller.release(foot)
    assert controller(scene.q, scene.v).ok
    assert not np.isfinite(rows.upper).any()


def test_friction_is_named_by_its_points() -> None:
    scene = humanoid(friction=0.05)
    push = ForceTask([100.0, 0.0, 150.0], contact=scene.feet[0])
    _, _, step = stepped(scene, push)
    line = next(line for line in str(step.solution.explain()).splitlines() if line.startswith("left: force short by"))
    assert "left: friction, at 4 of 4 points" in line


def test_friction_is_named_by_the_points_that_it_holds() -> None:
    """Each of them is at its pyramid, and they are not always all."""
    scene, counts = humanoid(friction=0.3), set()
    for seed in (14, 18, 21, 23, 24, 27, 36, 37):
        com = scene.com + np.random.default_rng(seed).uniform(-0.1, 0.1, 3)
        stack = scene.limits >> CenterOfMassTask(com, gain=6.0) >> scene.rest()
        step = Controller(scene.robot, stack, order="torque", dt=DT, damping=None)(*moved(scene, seed, 0.02))
        h = step.solution.hierarchy
        labels = [label for level in h.levels for label in level.labels]
        for cause in (cause for level in step.solution.explain().levels for cause in level.causes):
            if not cause.part.endswith("friction"):
                continue
            points = {labels[row].place for row in cause.rows}
            counts.add(len(points))
            assert f"{cause}" == f"{cause.part}, at {len(points)} of 4 points"
            value = h.dense()[list(cause.rows)] @ step.solution.x
            np.testing.assert_allclose(value, 0.0, atol=1e-6)
    assert counts - {4}


def test_a_quadruped_lifts_a_leg_by_a_trajectory() -> None:
    robot = load_robot("go2", acceleration_limit=1000.0)
    q, v = np.array(robot.home), np.zeros(robot.nv)
    state = robot.at(q, v)
    legs = ("FL", "FR", "RL", "RR")
    feet = {leg: Contact(f"{leg}_foot", friction=0.6, name=leg) for leg in legs}
    stand = Dynamics() + feet["FL"] + feet["FR"] + feet["RL"] + feet["RR"]
    three = np.mean([state.frame(f"{leg}_foot").position for leg in legs[1:]], axis=0)
    com = Setpoint([*three[:2], state.center_of_mass.position[2]])
    swing = Setpoint(state.frame("FL_foot").position)
    lift = PositionTask(swing, frame="FL_foot", gain=20.0)
    up = OrientationTask(state.frame("base").rotation, frame="base", gain=10.0)
    tasks = CenterOfMassTask(com, gain=5.0) + up + lift
    stack = stand >> JointTorqueLimit() + JointLimits() >> tasks >> PostureTask(q, gain=5.0) + ForceTask(weight=1e-2)
    controller, start = Controller(robot, stack, order="torque", dt=DT, damping=None), swing(0.0)[0].copy()
    for k in range(1200):
        if k == 700:
            controller.release("FL", 0.1)
        if k > 850:
            swing.move(start + np.array([0.0, 0.0, 0.05]) * min((k - 850) / 200, 1.0))
        step = controller(q, v, k * DT)
        assert step.ok
        q, v = advanced(robot, q, v, step.a)
    there = robot.at(q, v)
    assert np.allclose(there.frame("FL_foot").position, start + np.array([0.0, 0.0, 0.05]), atol=1e-3)
    for leg in legs[1:]:
        assert np.allclose(there.frame(f"{leg}_foot").position, state.frame(f"{leg}_foot").position, atol=1e-5)
    assert step.solution.certify().ok


def test_refuses_what_has_no_forces_or_no_contact() -> None:
    robot: PinocchioRobot = g1()
    q = np.array(robot.home)
    foot = Contact(FEET[0], friction=0.6)
    for stack, named in (
        (Dynamics() >> ForceTask(), "no contact in the stack"),
        (Dynamics() >> SupportLimit(), "no contact in the stack"),
        (Dynamics() >> CapturePointTask([0.0, 0.0], gain=1.0), "no contact in the stack"),
        (Dynamics() + foot >> SupportLimit(gain=1000.0), "passes the bound within a tick"),
        (Dynamics() + foot >> TorqueTask(np.zeros(3)), "target has shape"),
    ):
        with pytest.raises(ValueError, match=named):
            Controller(robot, stack >> PostureTask(q, gain=1.0), order="torque", dt=DT, damping=None)
    with pytest.raises(ValueError, match="contacts have forces at torque"):
        Controller(robot, foot >> ForceTask(), dt=DT, damping=None)
    with pytest.raises(ValueError, match="kind = 'sideways'"):
        MomentumTask(kind="sideways", gain=1.0)
    with pytest.raises(ValueError, match="does not tell its momentum"):
        Controller(PlanarArm([1.0, 1.0]), MomentumTask(gain=1.0), damping=None)


@pytest.mark.parametrize(
    ("gravity", "fits"), [((0.0, 0.0, -9.8), True), ((0.0, 0.0, -1.62), False), ((9.81, 0, 0), False)]
)
def test_capture_points_are_those_of_the_earth(gravity, fits) -> None:
    """And refused elsewhere."""
    scene = quadruped()
    model = scene.robot.model.copy()
    model.gravity.linear = np.array(gravity)
    robot = PinocchioRobot(model, acceleration_limit=500.0)
    standing = Dynamics() + scene.feet[0] + scene.feet[1] >> JointLimits()
    for part in SupportLimit(), CapturePointTask([0.0, 0.0], gain=2.0):
        stack = standing >> part >> PostureTask(scene.q, gain=4.0)
        if fits:
            assert Controller(robot, stack, order="torque", dt=DT)(scene.q, scene.v).ok
        else:
            with pytest.raises(InvalidInput, match="a capture point needs that of the earth"):
                Controller(robot, stack, order="torque", dt=DT)
