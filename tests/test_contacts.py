"""Contacts: the laws of mechanics that their rows state, against Pinocchio and differences of positions."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
from pathlib import Path

import contact_scenes as scenes
import numpy as np
import pinocchio as pin
import pytest
from contact_scenes import DT, FEET, SOLE, Scene, advanced, humanoid, moved, quadruped

from hqp import InvalidInput
from tasks import (
    CenterOfMassTask,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    Loop,
    Part,
    PinocchioRobot,
    PoseTask,
    PositionTask,
    PostureTask,
    Stack,
    Step,
    SupportLimit,
    Surface,
    TorqueTask,
    load_robot,
    simulate,
    solve_ik,
)
from tasks.contacts.motion import ContactMotion

#: What forces, torques and accelerations may be off by [N], [N m], [m/s^2].
EXACT = 1e-9


def controller_of(scene: Scene, stack: Stack | None = None) -> Controller:
    wanted = scene.limits >> CenterOfMassTask(scene.com, gain=5.0) >> scene.rest() if stack is None else stack
    return Controller(scene.robot, wanted, order="torque", dt=DT, damping=None)


def point_jacobian(robot, q, frame, point):
    """Where a point of a frame is, and how it follows the joints, in the axes of the world."""
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, q)
    number = robot.frame_index(frame)
    place = pin.updateFramePlacement(robot.model, data, number)
    J = pin.getFrameJacobian(robot.model, data, number, pin.LOCAL_WORLD_ALIGNED)
    r = place.rotation @ np.asarray(point)
    return place.translation + r, J[:3] - pin.skew(r) @ J[3:], J[3:]


def from_forces(robot, q, step, contacts):
    """What the forces of a step come to in all joints, the base included."""
    total = np.zeros(robot.nv)
    for contact in contacts:
        given = step.forces[contact.name]
        if contact.wrench:
            _, J, turning = point_jacobian(robot, q, contact.frame, contact.shape.centre)
            total += J.T @ given[:3] + turning.T @ given[3:]
            continue
        lowest = (contact.radius or 0.0) * robot.at(q).frame(contact.frame).rotation.T @ contact.normal
        for point, f in zip(contact.shape.points - lowest, given, strict=True):
            total += point_jacobian(robot, q, contact.frame, point)[1].T @ f
    return total


def check_mechanics(scene: Scene, q, v, step: Step, outside=0.0) -> None:
    """The motion equation holds, in all joints; no force slips or pulls; no torque is beyond its limit."""
    robot, base = scene.robot, scene.robot.base
    needed = pin.rnea(robot.model, robot.model.createData(), q, v, step.a)
    left = needed - from_forces(robot, q, step, scene.feet) - outside
    assert np.abs(left[:base]).max(initial=0.0) < EXACT
    assert np.abs(left[base:] - step.tau).max() < EXACT
    assert (np.abs(step.tau) - robot.torque_limit[base:]).max() < EXACT
    for contact in scene.feet:
        f = step.forces[contact.name][:3][None] if contact.wrench else step.forces[contact.name]
        assert (np.hypot(f[:, 0], f[:, 1]) - contact.friction * f[:, 2]).max() < EXACT
        assert f[:, 2].min() > -EXACT


@pytest.mark.parametrize(
    "scene", [humanoid(), humanoid(rectangle=True, wrench=True), quadruped()], ids=("points", "wrenches", "quadruped")
)
def test_the_motion_equation_holds_and_no_limit_is_passed(scene: Scene) -> None:
    com = CenterOfMassTask(scene.com, gain=5.0)
    controller = controller_of(scene, scene.limits >> com >> PostureTask(scene.q, gain=4.0) + ForceTask(weight=0.01))
    for seed in range(4):
        q, v = moved(scene, seed, 0.02) if seed else (scene.q, scene.v)
        step = controller(q, v)
        assert step.ok
        assert step.solution.certify().ok
        check_mechanics(scene, q, v, step)


@pytest.mark.parametrize(
    ("shape", "motions"),
    [
        ({"points": SOLE}, 6),
        ({"plane": (0.1, 0.05)}, 6),
        ({"line": 0.1}, 5),
        ({"points": [(0.1, 0.0, 0.0), (0.0, 0.05, 0.0)]}, 5),
        ({"centre": (0.0, 0.0, -0.03)}, 3),
        ({"points": [(0.0, 0.0, 0.0)] * 3}, 3),
    ],
)
def test_what_a_contact_forbids_is_the_motion_of_its_points(shape, motions) -> None:
    scene, small = humanoid(), 1e-6
    robot, (q, v) = scene.robot, moved(scene, 1)
    contact = Contact(FEET[0], friction=0.5, normal=(0.1, -0.2, 1.0), **shape)
    motion, state = ContactMotion(contact), robot.at(q, v)
    J, drift = motion.jacobian(state), motion.drift(state)
    assert len(J) == motions
    # No joint motion that it leaves free moves one of its points; all that it forbids does.
    points = np.concatenate([point_jacobian(robot, q, contact.frame, p)[1] for p in contact.shape.points])
    assert np.linalg.matrix_rank(J, 1e-8) == motions == np.linalg.matrix_rank(points, 1e-8)
    assert np.linalg.matrix_rank(np.concatenate([J, points]), 1e-8) == motions
    # Its drift is how its rates change while the joints do not accelerate.
    ahead, behind = (
        np.concatenate(
            [
                np.concatenate([here @ v, turning @ v])
                for _, here, turning in [
                    point_jacobian(robot, robot.integrate(q, s * v), FEET[0], contact.shape.centre)
                ]
            ]
        )
        for s in (small, -small)
    )
    change = (ahead - behind) / (2 * small)
    _, at_centre, turning = point_jacobian(robot, q, FEET[0], contact.shape.centre)
    along = np.linalg.lstsq(np.concatenate([at_centre, turning]).T, J.T, rcond=None)[0].T  # the axes of its rows
    assert np.allclose(drift, along @ change, atol=1e-6)


def test_forces_act_at_their_points() -> None:
    """G is how the points move, by differences: power is force times velocity."""
    scene, small = humanoid(), 1e-6
    q, v = moved(scene, 2)
    robot = scene.robot
    step = controller_of(scene)(q, v)
    power = sum(
        f @ (point_jacobian(robot, robot.integrate(q, small * v), foot.frame, p)[0] - where) / small
        for foot in scene.feet
        for p, f in zip(foot.shape.points, step.forces[foot.name], strict=True)
        for where in [point_jacobian(robot, q, foot.frame, p)[0]]
    )
    assert np.isclose(from_forces(robot, q, step, scene.feet) @ v, power, atol=1e-3)


def test_a_sole_of_points_and_one_of_a_wrench_bear_the_same() -> None:
    steps = []
    for scene in humanoid(rectangle=True), humanoid(rectangle=True, wrench=True):
        com = CenterOfMassTask(scene.com + np.array([0.01, 0.02, 0.0]), gain=5.0)
        stack = scene.limits >> com >> PostureTask(scene.q, gain=4.0)
        steps.append((scene, controller_of(scene, stack)(scene.q, scene.v)))
    (points, first), (wrench, second) = steps
    assert np.allclose(first.a, second.a, atol=1e-7)
    total = [from_forces(s.robot, s.q, step, s.feet)[:6] for s, step in steps]
    assert np.allclose(total[0], total[1], atol=1e-6)
    assert second.forces["left"].shape == (6,)
    for foot in wrench.feet:  # within the rectangle, on the plane of the sole
        x, y, z = second.cop[foot.name]
        assert abs(x - 0.035) <= 0.085 + 1e-9
        assert abs(y) <= 0.03 + 1e-9
        assert np.isclose(z, -0.03)
    assert points.feet[0].unknowns == 12


def test_ideal_sine_of_the_centre_of_mass() -> None:
    """The first exercise of inverse dynamics on a biped: what is asked for is done, and proved."""
    scene = humanoid()

    def sine(t):
        w, way, begun = np.pi, np.array([0.0, 0.03, 0.0]), min(t / 0.5, 1.0)
        share, rate, change = begun**3 * (10 - 15 * begun + 6 * begun**2), 0.0, 0.0
        if t < 0.5:
            rate, change = 30 * (begun * (1 - begun)) ** 2 / 0.5, 60 * begun * (1 - begun) * (1 - 2 * begun) / 0.25
        s, c = np.sin(w * t), np.cos(w * t)
        return (
            scene.com + way * share * s,
            way * (rate * s + share * w * c),
            way * (change * s + 2 * rate * w * c - share * w * w * s),
        )

    controller = controller_of(scene, scene.limits >> CenterOfMassTask(sine, gain=5.0) >> scene.rest())
    q, v, worst = scene.q, scene.v, 0.0
    for k in range(500):
        step = controller(q, v, k * DT)
        assert step.ok
        if k % 25 == 0:
            assert step.solution.certify().ok
            check_mechanics(scene, q, v, step)
        q, v = advanced(scene.robot, q, v, step.a)
        worst = max(worst, np.linalg.norm(scene.robot.at(q, v).center_of_mass.position - sine((k + 1) * DT)[0]))
    assert worst < 1e-3
    for foot in scene.feet:
        here, there = (scene.robot.at(p, v).frame(foot.frame).position for p in (q, scene.q))
        assert np.linalg.norm(here - there) < 1e-5


def test_a_run_is_recorded_with_its_torques() -> None:
    scene = humanoid()
    task = CenterOfMassTask(scene.com + np.array([0.0, 0.02, 0.0]), gain=5.0)
    record = simulate(controller_of(scene, scene.limits >> task >> scene.rest()), scene.q, duration=0.2)
    assert record.tau.shape == (100, 29)
    assert record.certified_share == 1.0
    assert record.active["torque"].shape == (100, 29)
    assert not record.active["torque"].any()
    step = controller_of(scene, scene.limits >> task >> scene.rest())(scene.q, scene.v)
    assert np.allclose(record.tau[0], step.tau)


def test_a_switch_changes_no_structure_and_jumps_nowhere() -> None:
    scene = humanoid()
    over = scene.robot.at(scene.q, scene.v).frame(FEET[0]).position
    com = np.array([scene.com[0], over[1], scene.com[2]])
    foot = scene.robot.at(scene.q, scene.v).frame(FEET[1])
    swing = PoseTask((foot.position, foot.rotation), frame=FEET[1], gain=20.0)
    controller = controller_of(scene, scene.limits >> CenterOfMassTask(com, gain=6.0) + swing >> scene.rest())
    q, v, taus = scene.q, scene.v, []
    rows, solver, hierarchy = controller._rows, controller._now.solver, controller.hierarchy
    for k in range(1100):
        if k == 700:
            controller.release("right", 0.2)
        if k == 900:
            controller.make(scene.feet[1], 0.2)
        step = controller(q, v, k * DT)
        assert step.ok
        if 800 <= k < 900:
            assert np.abs(step.forces["right"]).max() < EXACT
        if k % 50 == 0:
            assert step.solution.certify().ok
            check_mechanics(scene, q, v, step)
        taus.append(step.tau)
        q, v = advanced(scene.robot, q, v, step.a)
    assert (rows, solver, hierarchy) == (controller._rows, controller._now.solver, controller.hierarchy)
    jumps = np.abs(np.diff(taus, axis=0)).max(axis=1)
    assert jumps[695:895].max() < 0.05
    assert jumps[895:].max() < 0.5  # those of a ramp up to the weight, of 0.2 s


def test_a_foot_that_may_slip_slips_rather_than_that_a_limit_is_passed() -> None:
    """The ground is pulled away faster than friction can follow."""
    still = np.zeros(3)
    for may_slip in False, True:
        scene = humanoid(friction=0.1, may_slip=may_slip, surface=Surface(lambda t: (still, still, [300.0, 0.0, 0.0])))
        step = controller_of(scene, scene.limits >> PostureTask(scene.q, gain=4.0))(scene.q, scene.v)
        assert step.ok
        assert step.solution.certify().ok
        told = str(step.solution.explain()).splitlines()
        if may_slip:
            check_mechanics(scene, scene.q, scene.v, step)
            assert next(line for line in told if "left short by" in line).count("friction")
        else:  # what it is to hold stands above its friction
            assert any("friction short by" in line for line in told)


def test_a_change_of_stacks_keeps_the_motion_equation_all_the_way() -> None:
    scene = humanoid()
    limits = scene.limits
    here, there = (CenterOfMassTask(scene.com + np.array([0.0, y, 0.0]), gain=5.0) for y in (0.02, -0.02))
    controller, q, v = controller_of(scene, limits >> here >> scene.rest()), scene.q, scene.v
    for k in range(120):
        if k == 20:
            controller.change(limits >> there >> scene.rest(), duration=0.1)
        step = controller(q, v, k * DT)
        assert step.ok
        if k % 10 == 5:
            check_mechanics(scene, q, v, step)
        q, v = advanced(scene.robot, q, v, step.a)
    assert step.share == 1.0


def test_off_is_as_if_it_were_not_there() -> None:
    scene = humanoid()
    com = CenterOfMassTask(scene.com, gain=5.0)
    both = controller_of(scene, scene.limits >> com >> PostureTask(scene.q, gain=4.0))
    alone = Scene(*scene[:4], scene.feet[:1])
    other = CenterOfMassTask(scene.com, gain=5.0)
    one = controller_of(alone, alone.limits >> other >> PostureTask(scene.q, gain=4.0))
    both.release("right")
    first, second = both(scene.q, scene.v), one(scene.q, scene.v)
    assert np.allclose(first.a, second.a, atol=1e-6)
    assert np.allclose(first.tau, second.tau, atol=1e-6)
    assert np.isnan(first.cop["right"]).all()
    assert not first.forces["right"].any()


@pytest.mark.parametrize("far", [0.0, 0.3], ids=["near", "out of reach"])
@pytest.mark.parametrize("rests", ["posture", "posture and least forces"])
def test_a_contact_that_is_off_has_no_force_at_all_tick_after_tick(rests: str, far: float) -> None:
    """Not even round-off, of which a centre of pressure would be made."""
    scene = humanoid()
    com = CenterOfMassTask(scene.com + far * np.eye(3)[0], gain=5.0)
    last = PostureTask(scene.q, gain=4.0)
    if rests != "posture":
        last = last + ForceTask(weight=0.01)
    controller, q, v = controller_of(scene, scene.limits >> com >> last), scene.q, scene.v
    controller.release("right")
    for k in range(12):
        step = controller(q, v, k * DT)
        assert not step.forces["right"].any()
        assert np.isnan(step.cop["right"]).all()
        q, v = advanced(scene.robot, q, v, step.a)


def test_a_surface_that_moves_takes_the_feet_along() -> None:
    def lift(t):
        return (
            np.array([0.02, 0.0, 0.02]) * (1 - np.cos(4 * t)),
            np.array([0.02, 0.0, 0.02]) * 4 * np.sin(4 * t),
            (np.array([0.02, 0.0, 0.02]) * 16 * np.cos(4 * t)),
        )

    scene = humanoid(surface=Surface(lift))
    controller = controller_of(scene, scene.limits >> scene.rest())
    q, v, dt = scene.q, scene.v, 5e-4
    start = scene.robot.at(q, v).frame(FEET[0]).position.copy()
    controller = Controller(scene.robot, controller.stack, order="torque", dt=dt, damping=None)
    for k in range(400):
        step = controller(q, v, k * dt)
        assert step.ok
        q, v = advanced(scene.robot, q, v, step.a, dt)
    assert np.allclose(scene.robot.at(q, v).frame(FEET[0]).position - start, lift(0.2)[0], atol=1e-4)


def test_a_tilted_surface_turns_the_cone() -> None:
    tilt = 0.3
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    turned = pin.exp3(np.array([0.0, tilt, 0.0]))
    for scene in humanoid(normal=normal), humanoid(surface=Surface(rotation=turned)):
        step = controller_of(scene, scene.limits >> scene.rest())(scene.q, scene.v)
        assert step.ok
        f = np.concatenate([step.forces[name] for name in step.forces])
        along = f @ normal
        assert (np.linalg.norm(f - along[:, None] * normal, axis=1) - 0.6 * along).max() < EXACT


def test_friction_is_inside_the_cone_for_any_number_of_faces() -> None:
    most = []
    for faces in 3, 4, 8, 16:
        scene = humanoid(faces=faces)
        task = ForceTask([200.0, 0.0, 100.0], contact=scene.feet[0])
        step = controller_of(scene, scene.limits >> task >> scene.rest())(scene.q, scene.v)
        f = step.forces["left"]
        assert (np.hypot(f[:, 0], f[:, 1]) - 0.6 * f[:, 2]).max() < EXACT
        most.append(np.hypot(*f.sum(axis=0)[:2]) / f[:, 2].sum())
    assert 0.55 < most[-1] <= 0.6 + EXACT


def test_normal_forces_keep_their_least_and_largest_sum() -> None:
    scene = humanoid()
    left, right = scene.feet
    controller = controller_of(scene)
    right.largest = 60.0
    assert controller(scene.q, scene.v).forces["right"][:, 2].sum() <= 60.0 + EXACT
    right.largest = np.inf
    right.least = 250.0
    assert controller(scene.q, scene.v).forces["right"][:, 2].sum() >= 250.0 - EXACT
    with pytest.raises(ValueError, match="least = 250 N must not exceed largest"):
        right.largest = 100.0
    assert left.largest == np.inf


def test_a_wrench_that_is_measured_is_counted() -> None:
    scene = humanoid()
    push = np.array([40.0, 10.0, 0.0, 1.0, 2.0, 3.0])
    standing = Dynamics({"torso_link": lambda t: push}) + scene.feet[0] + scene.feet[1]
    stack = standing >> JointTorqueLimit() + JointLimits() >> scene.rest()
    step = controller_of(scene, stack)(scene.q, scene.v)
    _, J, turning = point_jacobian(scene.robot, scene.q, "torso_link", np.zeros(3))
    check_mechanics(scene, scene.q, scene.v, step, J.T @ push[:3] + turning.T @ push[3:])


def test_at_velocity_order_a_contact_is_its_motion_alone() -> None:
    scene = humanoid()
    com = scene.com + np.array([0.02, 0.03, -0.02])
    stack = scene.feet[0] + scene.feet[1] >> JointLimits() >> CenterOfMassTask(com, gain=5.0)
    controller, q, v = Controller(scene.robot, stack, dt=0.005, damping=None), scene.q, scene.v
    for k in range(400):
        step = controller(q, v, 0.005 * k)
        q, v = scene.robot.integrate(q, 0.005 * step.v), step.v
    state = scene.robot.at(q, v)
    assert step.forces is None
    assert np.linalg.norm(state.center_of_mass.position - com) < 1e-4
    for foot in scene.feet:
        assert (
            np.linalg.norm(state.frame(foot.frame).position - scene.robot.at(scene.q, v).frame(foot.frame).position)
            < 1e-4
        )


def test_at_velocity_order_a_foot_is_released_and_made() -> None:
    scene = humanoid()
    left, right = scene.feet
    start = scene.robot.at(scene.q, scene.v).frame(FEET[1]).position.copy()
    lift = PositionTask(start + np.array([0.0, 0.0, 0.05]), frame=FEET[1], gain=5.0)
    stack = left + right >> JointLimits() >> lift
    controller, q, v, heights = Controller(scene.robot, stack, dt=0.005, damping=None), scene.q, scene.v, []
    for k in range(600):
        if k in (100, 400):
            (controller.release if k == 100 else controller.make)("right", 0.2)
        if k == 400:
            lift.target = start
        step = controller(q, v, 0.005 * k)
        q, v = scene.robot.integrate(q, 0.005 * step.v), step.v
        heights.append(scene.robot.at(q, v).frame(FEET[1]).position[2] - start[2])
    assert abs(heights[99]) < 1e-9
    assert np.isclose(heights[399], 0.05, atol=1e-3)
    assert np.isclose(heights[599], heights[401], atol=1e-6)  # it holds where it was made


def test_inverse_kinematics_keeps_contacts() -> None:
    scene = humanoid()
    com = scene.com + np.array([0.01, 0.02, -0.03])
    stack = scene.feet[0] + scene.feet[1] >> JointLimits() >> CenterOfMassTask(com, gain=1.0)
    found = solve_ik(scene.robot, stack, scene.q)
    assert found.reached
    for frame in FEET:
        here, there = (scene.robot.at(q, scene.v).frame(frame).position for q in (found.q, scene.q))
        assert np.linalg.norm(here - there) < 1e-6


def test_a_hand_presses_a_table() -> None:
    """A fixed base: no rows of a base, and the torques are those of the motion less those of the forces."""
    robot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=50.0)
    hand = Contact("panda_hand", centre=(0.0, 0.0, 0.1), friction=0.5, name="hand")
    press = ForceTask([20.0], contact=hand)
    rest = PostureTask(robot.home, gain=4.0) + ForceTask(weight=1e-3)
    stack = Dynamics() + hand >> JointTorqueLimit() + JointLimits() >> press >> rest
    controller, q, v = (
        Controller(robot, stack, order="torque", dt=DT, damping=None),
        np.array(robot.home),
        np.zeros(robot.nv),
    )
    for k in range(100):
        step = controller(q, v, k * DT)
        assert step.ok
        q, v = advanced(robot, q, v, step.a)
    assert step.solution.certify().ok
    assert np.isclose(step.forces["hand"][0, 2], 20.0)
    step = controller(q, v)
    needed = pin.rnea(robot.model, robot.model.createData(), q, v, step.a)
    assert np.allclose(needed - from_forces(robot, q, step, [hand]), step.tau, atol=EXACT)


@pytest.mark.parametrize("turns", [True, False])
def test_a_closed_chain_stays_closed_and_its_forces_are_equal_and_opposite(turns: bool) -> None:
    scene = humanoid()
    robot, state = scene.robot, scene.robot.at(scene.q, scene.v)
    a, b = state.frame("left_rubber_hand"), state.frame("right_rubber_hand")
    hands = Loop(
        "left_rubber_hand",
        "right_rubber_hand",
        at_b=b.rotation.T @ (a.position - b.position),
        turns=turns,
        name="hands",
    )
    standing = Dynamics() + scene.feet[0] + scene.feet[1] + hands
    stack = standing >> JointTorqueLimit() + JointLimits() >> scene.rest()
    target = a.position + np.array([0.05, 0.0, 0.05])
    stack = stack.inserted(PositionTask(target, frame="left_rubber_hand", gain=5.0), below=hands)
    controller, q, v = controller_of(scene, stack), scene.q, scene.v
    for k in range(300):
        step = controller(q, v, k * DT)
        assert step.ok
        q, v = advanced(robot, q, v, step.a)
    assert step.solution.certify().ok
    first, J, turning = point_jacobian(robot, q, hands.a, hands.at)
    other, J_b, turning_b = point_jacobian(robot, q, hands.b, hands.at_b)
    assert np.linalg.norm(first - other) < 1e-5
    assert np.linalg.norm(first - target) < 0.02
    step, f = controller(q, v), None
    f = step.forces["hands"]
    outside = (J - J_b).T @ f[:3] + (0.0 if turns else (turning - turning_b).T @ f[3:])
    check_mechanics(scene, q, v, step, outside)


def test_numbers_are_live() -> None:
    scene, other = humanoid(), humanoid(friction=0.2, gain=7.0)
    changed = controller_of(scene)
    changed(scene.q, scene.v)
    for foot in scene.feet:
        foot.friction, foot.gain = 0.2, 7.0
    q, v = moved(scene, 3)
    changed.release("right")
    changed.make("right")
    for foot in scene.feet[:1]:
        changed.release(foot)
        changed.make(foot)
    fresh = controller_of(other)
    first, second = changed(q, v), fresh(q, v)
    assert np.allclose(first.a, second.a, atol=1e-6)
    with pytest.raises(ValueError, match="frame is part of its structure"):
        scene.feet[0].frame = "pelvis"


def test_copies_know_which_contacts_are_off() -> None:
    scene = humanoid()
    controller = controller_of(scene)
    controller(scene.q, scene.v)
    controller.release("right")
    step = controller(scene.q, scene.v, DT)
    for made in copy.deepcopy(controller), pickle.loads(pickle.dumps(controller)):
        again = made(scene.q, scene.v, DT)
        assert np.allclose(again.a, step.a, atol=1e-6)
        assert not again.forces["right"].any()


def test_what_is_no_number_gives_no_torque() -> None:
    scene = humanoid()
    controller = controller_of(scene)
    broken = scene.q.copy()
    broken[10] = np.nan
    for t in range(2):
        step = controller(broken, scene.v, t * DT)
        assert not step.ok
        assert not step.tau.any()
    step = controller(scene.q, scene.v)  # and the feet stand where they are first seen
    assert step.ok
    check_mechanics(scene, scene.q, scene.v, step)


def test_an_ordinary_stack_has_one_block() -> None:
    robot = load_robot("panda")
    controller = Controller(robot, JointLimits() >> PostureTask(robot.home, gain=1.0), dt=0.01, damping=None)
    assert controller._rows.unknowns.n == controller.hierarchy.n == robot.nv
    assert controller._rows.levels.parts == controller.stack.levels
    assert controller(robot.home, np.zeros(robot.nv)).forces is None


def test_redundant_contacts_are_handled_by_rank() -> None:
    scene = humanoid()
    twice = Contact(FEET[0], points=SOLE, friction=0.6, name="again")
    both = Scene(*scene[:4], (*scene.feet, twice))
    step = controller_of(both)(scene.q, scene.v)
    assert step.ok
    assert step.solution.certify().ok
    check_mechanics(both, scene.q, scene.v, step)


def test_the_interpreter_writes_the_same_rows(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", scenes.__file__, str(tmp_path / "rows.npz")],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    theirs, mine = np.load(tmp_path / "rows.npz"), scenes.rows()
    assert set(theirs.files) == set(mine)
    for name, numbers in mine.items():
        most = np.abs(numbers, where=np.isfinite(numbers), out=np.zeros_like(numbers)).max()
        assert np.allclose(theirs[name], numbers, rtol=0.0, atol=1e-12 * most), name


REFUSED = {
    "friction = 0.0 must be positive": lambda: Contact("foot", friction=0.0),
    "friction = -1.0 must be positive": lambda: Contact("foot", friction=-1.0),
    r"points have shape \(0,\)": lambda: Contact("foot", points=[]),
    r"points have shape \(0, 3\)": lambda: Contact("foot", points=np.zeros((0, 3))),
    "points and plane are given": lambda: Contact("foot", points=SOLE, plane=(0.1, 0.1)),
    "faces": lambda: Contact("foot", faces=2),
    "must be a direction": lambda: Contact("foot", normal=(0, 0, 0)),
    "wrench = True takes a plane": lambda: Contact("foot", wrench=True),
    "both frames are 'foot'": lambda: Loop("foot", "foot"),
    "a target is for the forces of one contact": lambda: ForceTask([1.0]),
    "joint damping = -1": lambda: Dynamics(joint_damping=-1.0),
}


@pytest.mark.parametrize("named", REFUSED)
def test_refuses_what_cannot_be(named: str) -> None:
    with pytest.raises(ValueError, match=named):
        REFUSED[named]()


def test_refuses_stacks_and_robots_that_do_not_fit() -> None:
    scene = humanoid()
    left, right = scene.feet
    robot = scene.robot
    posture = PostureTask(scene.q, gain=4.0)
    bare = load_robot("g1", torque_limit=np.full(robot.nv, np.inf))
    rough = Contact(FEET[0], points=SOLE)
    arm, fixed = load_robot("panda"), Contact("panda_link0", friction=0.5)
    cases = {
        r"the stack has no Dynamics\(\)": (robot, left + right >> posture),
        "has no torque limit of its own": (bare, Dynamics() + left >> JointTorqueLimit() >> posture),
        "needs its friction": (robot, Dynamics() + rough >> posture),
        "'universe': no joint of": (robot, Dynamics() + left + Contact("universe", friction=0.5) >> posture),
        "'panda_link0': no joint of": (arm, Dynamics() + fixed >> PostureTask(arm.home, gain=1.0)),
        "is no frame of": (arm, Dynamics() + left >> PostureTask(arm.home, gain=1.0)),
        "is not in the stack": (robot, Dynamics() + left >> ForceTask([1.0], contact=right)),
        "floating base": (robot, TorqueTask() + posture),
    }
    for named, (on, stack) in cases.items():
        with pytest.raises(ValueError, match=named):
            Controller(on, stack, order="torque", dt=DT, damping=None)
    with pytest.raises(ValueError, match="velocities tell no forces"):
        Controller(robot, Dynamics() + left >> posture, dt=DT, damping=None)
    controller = controller_of(scene)
    for act, named in (
        (lambda: controller.release("lefft"), "did you mean 'left'"),
        (lambda: controller.make(left), "is on already"),
        (lambda: controller.release(left, -1.0), "must not be negative"),
        (lambda: controller.change(Dynamics() + left >> posture, duration=1.0), "other contacts"),
        (lambda: controller.change(left >> posture, duration=0.0), r"no Dynamics\(\)"),
    ):
        with pytest.raises(ValueError, match=named):
            act()


@pytest.mark.parametrize("beside", [[], [JointTorqueLimit(), JointLimits()]], ids=["alone", "with limits"])
@pytest.mark.usefixtures("nothing_told")
def test_a_robot_without_contacts_is_said_to_fall(beside: list[Part], caplog: pytest.LogCaptureFixture) -> None:
    scene = humanoid()
    stack = Stack(Dynamics(), *beside, PostureTask(scene.q, gain=4.0))
    controller = Controller(scene.robot, stack, order="torque", dt=DT, damping=None)
    assert "it falls" in caplog.text
    step = controller(scene.q, scene.v)
    assert np.allclose(scene.robot.at(scene.q, scene.v).center_of_mass.linear @ step.a, [0.0, 0.0, -9.81], atol=1e-6)


def test_the_bounds_of_a_contact_are_those_of_all_its_rows() -> None:
    scene = humanoid()
    controller = controller_of(scene)
    controller(scene.q, scene.v)
    h, (lower, upper) = controller.hierarchy, controller.bounds(scene.feet[0])
    parts = [h.label_of(row).part for row in range(h.m)]
    own = [i for i, part in enumerate(parts) if part.split(":")[0] == "left" and part != "left: force"]
    assert len(own) == 12 + 6 + 17  # forces, motion, friction
    np.testing.assert_array_equal(lower, h.lower[own])
    np.testing.assert_array_equal(upper, h.upper[own])


def test_degrees_of_redundancy_count_forces_too(tmp_path: Path) -> None:
    scene = humanoid()
    record = simulate(controller_of(scene), scene.q, duration=2 * DT, certify=1)
    n = scene.robot.nv + 24
    assert record.degrees.redundancy.min() >= 0
    np.testing.assert_array_equal(record.degrees.redundancy, n - np.cumsum(record.ranks, axis=1))
    record.save(tmp_path / "r.npz")
    assert type(record).load(tmp_path / "r.npz").unknowns == n


def test_forces_at_a_bound_are_told_by_how_many_points() -> None:
    """A foot that is asked to press no more than it can lift off its points: all push, and are one cause."""
    scene = humanoid()
    pull = ForceTask([-50.0], contact=scene.feet[0], weight=1.0)
    stack = Dynamics() + scene.feet[0] + scene.feet[1] >> pull >> scene.rest()
    told = str(controller_of(scene, stack)(scene.q, scene.v).solution.explain())
    assert "left: forces, at 4 of 4 points" in told, told


COPIES = {"deepcopy": copy.deepcopy, "copy": copy.copy, "pickle": lambda value: pickle.loads(pickle.dumps(value))}


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("moment", ["a release", "a release of its motion", "a making", "all on", "one off"])
def test_a_copy_goes_on_as_the_original_does(how: str, moment: str) -> None:
    """At every moment, whatever is under way, and wherever the contacts have been made."""
    scene = humanoid()
    controller = controller_of(scene)
    q, v, t = scene.q, scene.v, 1.0

    def ticks(count: int) -> None:
        nonlocal q, v, t
        for _ in range(count):
            q, v = advanced(scene.robot, q, v, controller(q, v, t).a)
            t += DT

    ticks(3)
    if moment != "all on":
        controller.release("right", duration=0.0 if moment == "one off" else 20 * DT)
        ticks({"a release": 5, "a release of its motion": 25}.get(moment, 45))
    if moment == "a making":
        controller.make("right", duration=20 * DT)
        ticks(5)
    other = COPIES[how](controller)
    for _ in range(3):
        mine, theirs = controller(q, v, t), other(q, v, t)
        assert other.loaded == controller.loaded
        assert np.allclose(theirs.a, mine.a, atol=1e-6)
        assert np.allclose(theirs.tau, mine.tau, atol=1e-6)
        q, v = advanced(scene.robot, q, v, mine.a)
        t += DT
    if moment == "all on":
        other = COPIES[how](controller)
        for each in controller, other:
            each.release("right", duration=0.1)
        assert np.allclose(other(q, v, t).tau, controller(q, v, t).tau, atol=1e-6)


def test_a_run_begins_where_the_robot_is() -> None:
    """And not where it stood in the run before."""
    scene = humanoid()
    controller = controller_of(scene)
    first = simulate(controller, scene.q, duration=10 * DT)
    way = np.zeros(scene.robot.nv)
    way[:2] = 3.0, -2.0
    second = simulate(controller_of(scene), scene.robot.integrate(scene.q, way), duration=10 * DT)
    again = simulate(controller, scene.robot.integrate(scene.q, way), duration=10 * DT)
    assert first.stopped is None
    assert np.allclose(again.v, second.v, atol=1e-6)


@pytest.mark.parametrize("turned_back", [0.0, 4.9])
def test_time_that_is_set_back_does_not_hold_up_a_ramp(turned_back: float) -> None:
    scene = humanoid()
    controller = controller_of(scene)
    controller(scene.q, scene.v, 5.0)
    controller.release("right", duration=10 * DT)
    for k in range(5):
        before = controller(scene.q, scene.v, 5.0 + k * DT).forces.normal("right").sum()
    normals = [controller(scene.q, scene.v, turned_back + k * DT).forces.normal("right").sum() for k in range(30)]
    assert normals[0] <= before + 1e-9
    assert (np.diff(normals) <= 1e-6).all()
    assert normals[-1] == 0.0
    assert "right" not in controller.loaded


def test_names_of_contacts_name_one_thing() -> None:
    """By a name forces are read, and contacts released."""
    scene = humanoid()
    one, two = (Contact(frame, points=SOLE, friction=0.6, name="foot") for frame in FEET)
    rest = PostureTask(scene.q, gain=4.0)
    with pytest.raises(InvalidInput, match="several parts with forces are named 'foot'; give each a name of its own"):
        Controller(scene.robot, Dynamics() + one + two >> rest, order="torque", dt=DT)
    without_forces = Controller(scene.robot, one + two >> rest, dt=DT)
    with pytest.raises(InvalidInput, match="'foot' names 2 contacts of the stack"):
        without_forces.release("foot")
    without_forces.release(two)
    assert without_forces.bears(one)
    assert not without_forces.bears(two)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 0.0), (0.0, 0.0, 1e-200)])
def test_a_normal_without_a_direction_is_refused(normal: tuple[float, float, float]) -> None:
    with pytest.raises(InvalidInput, match="must be a direction"):
        Contact(FEET[0], friction=0.6, normal=normal)


WALKER = """<mujoco><worldbody><body name="torso" pos="0 0 0.86"><joint name="x" type="slide" axis="1 0 0"/>
<joint name="z" type="slide" axis="0 0 1"/><joint name="pitch" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 .4" size=".1" mass="20"/>{}</body></worldbody></mujoco>"""
LEG = """<body><joint name="{0} hip" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.45" size=".05" mass="5"/>
<body pos="0 0 -.45"><joint name="{0} knee" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -.45" size=".04" mass="3"/>
<body name="{0}" pos="0 0 -.45"><joint name="{0} ankle" axis="0 1 0"/><geom type="box" size=".1 .05 .02" mass="1"/>
</body></body></body>"""


def test_a_robot_in_the_plane_whose_base_has_joints_without_motors(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "walker.xml"
    path.write_text(WALKER.format(LEG.format("left") + LEG.format("right")))
    motors = {"x": 0.0, "z": 0.0, "pitch": 0.0}
    robot = load_robot(path, velocity_limit=20.0, acceleration_limit=300.0, torque_limit=motors)
    robot = pickle.loads(pickle.dumps(robot))
    assert robot.torque_limit.tolist() == [0.0] * 3 + [np.inf] * 6
    bent = {"hip": -0.3, "knee": 0.6, "ankle": -0.3}
    q = robot.configuration({f"{side} {joint}": angle for side in ("left", "right") for joint, angle in bent.items()})
    v = np.zeros(robot.nv)
    com = robot.at(q).center_of_mass.position + np.array([0.02, 0.0, -0.02])
    feet = [Contact(side, points=[(-0.1, 0, -0.02), (0.1, 0, -0.02)], friction=0.6) for side in ("left", "right")]
    limits = Dynamics() + feet[0] + feet[1] >> JointTorqueLimit() + JointLimits() >> SupportLimit()
    stack = limits >> CenterOfMassTask(com, gain=5.0) >> PostureTask(q, gain=4.0) + ForceTask(weight=1e-2)
    controller = Controller(robot, stack, order="torque", dt=DT)
    weight = 9.81 * sum(inertia.mass for inertia in robot.model.inertias)
    for k in range(600):
        step = controller(q, v, k * DT)
        assert abs(step.tau[:3]).max() <= 1e-9 * weight
        q, v = advanced(robot, q, v, step.a)
    assert step.solution.certify().ok
    assert abs(robot.at(q).center_of_mass.position - com)[[0, 2]].max() < 1e-3
    assert sum(f[:, 2].sum() for f in step.forces.values()) == pytest.approx(weight, rel=1e-2)


@pytest.mark.parametrize("before", ["nothing", "a tick", "a tick of NaN", "both"])
@pytest.mark.parametrize("made", [False, True], ids=["release", "release and make"])
def test_a_ramp_is_one_whatever_was_before_it(before: str, made: bool) -> None:
    """Where no tick, or one of NaN, had told forces, they fell to 0 at once; and rose from 0 at the end of the ramp."""
    scene = quadruped()
    foot = scene.feet[0].name
    rest = PostureTask(scene.q, gain=4.0) + ForceTask(weight=1e-2)
    controller = controller_of(scene, scene.limits >> CenterOfMassTask(scene.com, gain=5.0) >> rest)
    if before in ("a tick", "both"):
        controller(scene.q, scene.v)
    if before in ("a tick of NaN", "both"):
        assert not controller(np.full(scene.robot.nq, np.nan), scene.v).ok
    if made:
        controller.release(foot)
        controller.make(foot, duration=20 * DT)
    else:
        controller.release(foot, duration=20 * DT)
    borne = [controller(scene.q, scene.v, k * DT).forces[foot][:, 2].sum() for k in range(25)]
    weight = 9.81 * sum(inertia.mass for inertia in scene.robot.model.inertias)
    assert np.abs(np.diff(borne)).max() < 1.51 / 20 * weight  # a cubic has 1.5 times the mean speed
    assert sorted(borne, reverse=not made) == pytest.approx(borne, abs=1e-6)
    assert max(borne) > 0.1 * weight
    assert min(borne) < 1e-6 * weight


@pytest.mark.parametrize("share", [0.02, 3.0])
def test_a_contact_that_is_made_is_asked_for_no_more_than_it_may_bear(share: float) -> None:
    """Its least force was asked for at once, while the cap was 0: the level of the limits could not be kept."""
    scene = quadruped()
    foot = scene.feet[0]
    weight = 9.81 * sum(inertia.mass for inertia in scene.robot.model.inertias)
    controller = controller_of(scene, scene.limits >> PostureTask(scene.q, gain=4.0) + ForceTask(weight=1e-2))
    controller(scene.q, scene.v)
    foot.least = share * weight
    controller.release(foot)
    controller(scene.q, scene.v, DT)
    controller.make(foot, duration=10 * DT)
    for k in range(20):
        step = controller(scene.q, scene.v, (2 + k) * DT)
        low, high = controller.bounds(foot)
        assert low[-1] <= high[2] + 1e-9  # the least sum, and the cap of its one point
        if share < 1.0:
            assert step.solution.levels[2].residual_norm < 1e-9
    assert low[-1] == pytest.approx(foot.least)


def test_a_stack_without_forces_tells_none() -> None:
    """After a change it told those of the last tick of the stack before, for ever."""
    scene = quadruped()
    controller = controller_of(scene, scene.limits >> PostureTask(scene.q, gain=4.0))
    assert controller(scene.q, scene.v).forces is not None
    controller.change(Dynamics() >> JointTorqueLimit() >> PostureTask(scene.q, gain=4.0), duration=0.0)
    step = controller(scene.q, scene.v)
    assert step.forces is None
    assert step.cop is None


def two_quadrupeds() -> PinocchioRobot:
    """Two robots in one model, whose joints and frames begin with a and b: only the first has the base."""
    one = load_robot("solo12")
    models = []
    for prefix in "ab":
        model = pin.Model(one.model)
        for i in range(1, model.njoints):
            model.names[i] = prefix + model.names[i]
        for frame in model.frames:
            frame.name = prefix + frame.name
        models.append(model)
    beside = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    robot = PinocchioRobot(pin.appendModel(*models, 0, beside), velocity_limit=20.0, acceleration_limit=200.0)
    robot.home = np.tile(one.home, 2)
    return robot


@pytest.mark.usefixtures("nothing_told")
@pytest.mark.parametrize("limit", [JointTorqueLimit(), JointTorqueLimit(40.0)], ids=["own", "a number"])
def test_no_motor_bears_a_second_robot_of_the_model(limit: JointTorqueLimit, caplog: pytest.LogCaptureFixture) -> None:
    """Its base was driven by six torques that no motor has: its feet bore nothing, and every tick was certified."""
    with caplog.at_level("WARNING"):
        robot = two_quadrupeds()
    assert "it is 0 of joints that float, or stand in the plane, besides the base: broot_joint" in caplog.text
    free = [name.startswith("broot_joint") for name in robot.joint_names]
    assert (robot.torque_limit == 0.0).tolist() == free
    robot.torque_limit = 30.0
    assert (robot.torque_limit == 0.0).tolist() == free
    feet = [Contact(f"{of}{leg}_FOOT", friction=0.6) for of in "ab" for leg in ("FL", "FR", "HL", "HR")]
    physics = sum(feet[1:], Dynamics() + feet[0])
    rest = PostureTask(robot.home, gain=4.0) + ForceTask(weight=1e-2)
    q, v = robot.home, np.zeros(robot.nv)
    com = CenterOfMassTask(robot.at(q).center_of_mass.position, gain=5.0)
    step = Controller(robot, physics >> limit + JointLimits() >> com >> rest, order="torque", dt=DT)(q, v)
    assert step.solution.certify().ok
    bias = robot.inverse_dynamics(q, v, step.a)
    for foot in feet:
        _, linear, _ = point_jacobian(robot, q, foot.frame, np.zeros(3))
        bias = bias - linear.T @ step.forces[foot.name][0]
    assert np.abs(bias[:6]).max() < 1e-8
    assert np.abs(bias[free]).max() < 1e-8
    for order, named in ("torque", "order = 'torque'"), ("acceleration", "Dynamics 'dynamics'"):
        with pytest.raises(InvalidInput, match=rf"{named}: no motor drives broot_joint\[0\].*; add JointTorqueLimit"):
            Controller(robot, physics >> JointLimits() >> com >> rest, order=order, dt=DT)


@pytest.mark.usefixtures("nothing_told")
def test_points_off_one_plane_are_told_and_borne(caplog: pytest.LogCaptureFixture) -> None:
    """A foot on uneven ground: each point has a force of its own, and the motion equation holds."""
    steps = [(x, y, -0.03 + 0.02 * (x > 0.0)) for x in (-0.05, 0.12) for y in (-0.03, 0.03)]
    bent = [(-0.05, -0.03, -0.03), (-0.05, 0.03, 0.03), (0.12, -0.03, -0.03), (0.12, 0.03, -0.03)]
    level = [(x, y, -0.03 + 1e-4 * (x * y > 0.0)) for x in (-0.05, 0.12) for y in (-0.03, 0.03)]
    for points, told in ((level, 0), (SOLE, 0), (steps, 0), (bent, 1)):
        caplog.clear()
        scene = humanoid(points=points)
        assert len([line for line in caplog.messages if "off one plane" in line]) == 2 * told
    controller = controller_of(scene)
    for seed in range(3):
        q, v = moved(scene, seed, 0.02)
        step = controller(q, v)
        assert step.solution.certify().ok
        check_mechanics(scene, q, v, step)
