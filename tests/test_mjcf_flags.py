"""Flags of an MJCF, and groups of its actuators: what a file disables, the robot does not have, and it is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tasks import PinocchioRobot, load_robot

pytest.importorskip("mujoco")

#: What a robot may have, each with the flags that disable it, and the word for it.
THINGS = {
    "range": ('range="-1 2"', ("limit", "constraint"), "ranges of joints"),
    "spring": ('stiffness="3" springref=".1"', ("spring",), "springs"),
    "damping": ('damping="2"', ("damper",), "damping"),
    "friction": ('frictionloss="1"', ("frictionloss", "constraint"), "dry friction"),
}
TIE = '<equality><joint joint1="b" joint2="a"/></equality>'
ROPE = '<tendon><fixed name="rope" range="0 1"><joint joint="a" coef="1"/></fixed></tendon>'
MOTORS = """<actuator><motor name="strong" joint="a" group="1" forcerange="-9 9"/>
<motor name="weak" joint="a" forcerange="-3 3"/>
<motor name="pulls" tendon="rope" group="1" forcerange="-5 5"/></actuator>"""


def robot_of(own: str = "", option: str = "", more: str = "") -> PinocchioRobot:
    import mujoco

    text = f"""<mujoco><compiler angle="radian"/><option {option}</option><worldbody>
      <body name="one"><joint name="a" axis="0 0 1" {own}/><geom size=".1"/><body name="two" pos=".3 0 0">
      <joint name="b" axis="0 1 0"/><geom size=".1"/></body></body></worldbody>{more}</mujoco>"""
    return load_robot(mujoco.MjModel.from_xml_string(text))


def flag(name: str) -> str:
    return f'><flag {name}="disable"/>'


def numbers(robot: PinocchioRobot) -> list[Any]:
    limits = [robot.position_limit, robot.torque_limit]
    own = [robot.model.damping.tolist(), robot.model.friction.tolist(), robot.springs]
    return [robot.joint_names, *(None if limit is None else limit.tolist() for limit in limits), *own]


@pytest.mark.parametrize(
    ("thing", "name"), [(thing, name) for thing, (_, names, _) in THINGS.items() for name in names]
)
def test_a_robot_has_nothing_of_what_a_flag_disables(thing: str, name: str) -> None:
    own, _, word = THINGS[thing]
    without, given, off = robot_of("", ">"), robot_of(own, ">"), robot_of(own, flag(name))
    assert numbers(off) == numbers(without) != numbers(given)
    assert off.left_out == (f"what the flags of the file disable: {word}",)
    others = [element for other, (element, names, _) in THINGS.items() if name not in names]
    assert numbers(robot_of(" ".join(others), flag(name))) == numbers(robot_of(" ".join(others), ">"))


@pytest.mark.parametrize("name", ["equality", "constraint"])
def test_nor_does_it_follow_disabled_equalities(name: str) -> None:
    assert robot_of("", ">", TIE).joint_names == ("a",)
    off = robot_of("", flag(name), TIE)
    assert off.joint_names == ("a", "b")
    assert off.left_out == ("what the flags of the file disable: equalities",)


def test_a_range_of_a_tendon_is_refused_unless_it_is_disabled() -> None:
    from hqp import InvalidInput

    with pytest.raises(InvalidInput, match="tendon 'rope' has a range"):
        robot_of("", ">", ROPE)
    assert robot_of("", flag("limit"), ROPE).left_out == ("what the flags of the file disable: ranges of joints",)


def test_motors_of_a_disabled_group_limit_nothing() -> None:
    """And those that are left have the joint for themselves."""
    more = ROPE.replace(' range="0 1"', "") + MOTORS
    both = robot_of("", ">", more)
    assert both.torque_limit is None  # which of them counts is not known
    one = robot_of("", 'actuatorgroupdisable="1">', more)
    assert one.torque_limit is not None
    np.testing.assert_array_equal(one.torque_limit, [3.0, np.inf])
    told = "the actuators that the file disables: strong, pulls (limits of their forces are not read)"
    assert one.left_out == (told,)


def test_a_file_may_disable_all_of_its_motors() -> None:
    more = MOTORS.replace('<motor name="pulls" tendon="rope" group="1" forcerange="-5 5"/>', "")
    off = robot_of("", flag("actuation"), more)
    assert off.torque_limit is None
    assert off.left_out == ("the actuators that the file disables: strong, weak (limits of their forces are not read)",)


def test_flags_of_what_a_robot_has_not_are_not_told() -> None:
    for name in "limit", "constraint", "equality", "spring", "damper", "frictionloss", "actuation", "contact":
        assert robot_of("", flag(name)).left_out == ()
