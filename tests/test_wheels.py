"""Wheels that roll: a base goes as its wheels turn, at both orders, and linear relations of joints beside them."""

from __future__ import annotations

import numpy as np
import pytest

from hqp import InvalidInput
from tasks import (
    Controller,
    Dynamics,
    JointVelocityTask,
    LinearHolonomicTask,
    OmniwheelTask,
    PlanarArm,
    RollingTask,
    Stack,
    load_robot,
    simulate,
    solve_ik,
)

RADIUS, HALF = 0.1, 0.25
INERTIA = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def cart(folder, wheels):
    """A base at the height of its wheels, which are told by place and yaw, their axles along their own y."""
    links, joints = [f'<link name="base">{INERTIA}</link>'], []
    for name, (x, y, yaw) in wheels.items():
        links.append(f'<link name="{name}">{INERTIA}</link>')
        joints.append(
            f'<joint name="{name}_joint" type="continuous"><parent link="base"/><child link="{name}"/>'
            f'<origin xyz="{x} {y} 0" rpy="0 0 {yaw}"/><axis xyz="0 1 0"/></joint>'
        )
    path = folder / "cart.urdf"
    path.write_text(f'<robot name="cart">{"".join(links)}{"".join(joints)}</robot>')
    return path


def two_wheels(folder, base):
    return load_robot(cart(folder, {"left": (0, HALF, 0), "right": (0, -HALF, 0)}), base=base)


def rolling(**options):
    floor = {"floor": -RADIUS, "gain": 5.0} | options
    return RollingTask(RADIUS, frame="left", name="left", **floor) + RollingTask(
        RADIUS, frame="right", name="right", **floor
    )


def test_a_wheel_is_driven_by_no_force_and_refused_beside_the_motion_equation(tmp_path) -> None:
    """The base would have to move by itself: rows of one level contradicted each other, and torques meant nothing."""
    robot = two_wheels(tmp_path, "planar")
    with pytest.raises(InvalidInput, match=r"RollingTask 'left': .* it is a Contact\('left', radius=0.1"):
        Controller(robot, Dynamics() + rolling(), order="torque", dt=0.01)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_cart_goes_as_its_wheels_turn(tmp_path, order) -> None:
    robot = two_wheels(tmp_path, "planar")
    turn = JointVelocityTask([3.0, 5.0], joints=["left_joint", "right_joint"])
    record = simulate(Controller(robot, rolling() >> turn, order=order, dt=0.01), robot.home, duration=1.0)
    v = record.v[-1]
    np.testing.assert_allclose(v[:3], [RADIUS * 4.0, 0.0, RADIUS * 2.0 / (2.0 * HALF)], atol=1e-6)  # along its own axes
    assert record.certified_share == 1.0


def test_a_base_that_may_lean_goes_as_its_wheels_turn_in_the_world(tmp_path) -> None:
    robot = two_wheels(tmp_path, "floating")
    turn = JointVelocityTask([3.0, 5.0], joints=["left_joint", "right_joint"])
    v = Controller(robot, rolling() >> turn, dt=0.01)(robot.home).v
    np.testing.assert_allclose(v[0], RADIUS * (4.0 + v[4]), atol=1e-9)
    np.testing.assert_allclose(v[5], RADIUS * 2.0 / (2.0 * HALF), atol=1e-9)


def test_height_is_brought_to_the_radius(tmp_path) -> None:
    robot = two_wheels(tmp_path, "floating")
    v = Controller(robot, Stack(rolling(floor=0.0)), dt=0.01)(robot.home).v
    np.testing.assert_allclose(v[2], 5.0 * RADIUS, rtol=1e-6)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("rollers", [0.0, np.pi / 4])
def test_omniwheels_turn_as_the_base_goes_anywhere(tmp_path, order, rollers) -> None:
    places = {f"w{k}": (0.3 * np.cos(a), 0.3 * np.sin(a), a + np.pi / 2) for k, a in enumerate([0.3, 2.4, 4.5])}
    robot = load_robot(cart(tmp_path, places), base="planar")
    wheels = Stack(*(OmniwheelTask(RADIUS, rollers=rollers, frame=w, floor=-RADIUS, gain=5.0, name=w) for w in places))
    joined = wheels.levels[0][0] + wheels.levels[1][0] + wheels.levels[2][0]
    twist = np.array([0.3, -0.2, 0.5])
    stack = joined >> JointVelocityTask(twist, joints=list(range(3)))
    record = simulate(Controller(robot, stack, order=order, dt=0.01), robot.home, duration=0.5)
    v = record.v[-1]
    np.testing.assert_allclose(v[:3], twist, rtol=1e-6)
    for (x, y, yaw), turn in zip(places.values(), v[3:], strict=True):
        ahead = np.array([np.cos(yaw), np.sin(yaw)])  # its own y is the axle, and y x z = x
        along = np.cos(rollers) * ahead + np.sin(rollers) * np.array([-ahead[1], ahead[0]])
        hub = twist[:2] + twist[2] * np.array([-y, x])
        np.testing.assert_allclose(along @ (hub - RADIUS * turn * ahead), 0.0, atol=1e-6)


def test_rows_say_what_slips(tmp_path) -> None:
    robot = two_wheels(tmp_path, "planar")
    stack = rolling() >> JointVelocityTask([0.0, 1.0, 0.0], joints=[0, 1, 2])  # aside, which wheels do not go
    told = str(Controller(robot, stack, dt=0.01)(robot.home).solution.explain())
    assert "joint velocity short by 1 m/s: left, then right" in told
    assert [label.row for label in next(iter(Controller(robot, stack, dt=0.01).describe())).rows][:2] == [
        "slip 1",
        "slip 2",
    ]


def test_wheels_need_a_robot_in_space() -> None:
    with pytest.raises(InvalidInput, match="moves in the plane; wheels take robots in space"):
        Controller(PlanarArm([1.0, 1.0]), Stack(RollingTask(0.1, gain=1.0)), dt=0.01)


# Linear relations.


def test_linear_relations_hold_from_a_configuration_on() -> None:
    panda, start = load_robot("panda", lock=["panda_finger_joint1"]), None
    start = panda.home + 0.1
    A = np.zeros((2, 7))
    A[0, [0, 2]], A[1, [1, 3]] = [1.0, -2.0], [1.0, 1.0]
    task = LinearHolonomicTask(A, [0.1, 0.2], start, gain=5.0)
    for order in "velocity", "acceleration":
        record = simulate(Controller(panda, Stack(task), order=order, dt=0.01), panda.home, duration=3.0)
        np.testing.assert_allclose(A @ (record.q[-1] - start), [0.1, 0.2], atol=1e-4)
    found = solve_ik(panda, Stack(task), seed=0)
    np.testing.assert_allclose(A @ (found.q - start), [0.1, 0.2], atol=1e-8)


def test_ways_on_a_circle_are_the_shorter_ones(tmp_path) -> None:
    robot = two_wheels(tmp_path, "planar")
    q0 = robot.configuration({"left_joint": 3.0})
    A = np.zeros((1, 5))
    A[0, 3] = 1.0
    task = LinearHolonomicTask(A, 0.0, q0, gain=1.0)
    error = task.error(robot.at(robot.configuration({"left_joint": -3.0})), 0.0)
    np.testing.assert_allclose(error, [-(2.0 * np.pi - 6.0)], rtol=1e-9)


def test_what_is_wrong_is_refused_in_words(tmp_path) -> None:
    robot = two_wheels(tmp_path, "floating")
    for make, words in (
        (lambda: LinearHolonomicTask(np.zeros((1, 3)), gain=1.0), "is zero"),
        (lambda: LinearHolonomicTask([1.0, 2.0], gain=1.0), "must be (rows, nv)"),
        (lambda: Controller(robot, Stack(LinearHolonomicTask(np.eye(8)[:1], gain=1.0)), dt=0.01), "no single position"),
        (lambda: Controller(robot, Stack(LinearHolonomicTask(np.eye(3), gain=1.0)), dt=0.01), "(rows, 8)"),
        (lambda: LinearHolonomicTask(np.eye(3), [1.0, 2.0], gain=1.0), "(3,)"),
        (lambda: RollingTask(-1.0, gain=1.0), "radius"),
        (lambda: OmniwheelTask(0.1, axle=[0.0, 0.0, 0.0], gain=1.0), "no direction"),
    ):
        with pytest.raises(InvalidInput) as refusal:
            make()
        assert words in str(refusal.value), words
