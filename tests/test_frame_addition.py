"""Frames that are added to a robot: as those of its file, wherever frames are named."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from contact_scenes import DT, quadruped

from hqp import InvalidInput
from tasks import CenterOfMassTask, Contact, Controller, MujocoPlant, PinocchioRobot, from_rpy, load_robot

TURNED = from_rpy(0.3, -0.2, 0.5)


def test_it_moves_with_the_frame_that_carries_it() -> None:
    robot, rng = load_robot("talos"), np.random.default_rng(0)
    on, at = "gripper_left_base_link", np.array([0.1, -0.02, 0.03])
    with_tool = robot.with_frame("tool", on=on, at=at, rotation=TURNED)
    q, v = robot.integrate(robot.home, 0.3 * rng.standard_normal(robot.nv)), rng.standard_normal(robot.nv)
    carrier, tool = robot.at(q, v).frame(on), with_tool.at(q, v).frame("tool")
    arm = carrier.rotation @ at
    np.testing.assert_allclose(tool.position, carrier.position + arm, atol=1e-12)
    np.testing.assert_allclose(tool.rotation, carrier.rotation @ TURNED, atol=1e-12)
    np.testing.assert_allclose(tool.angular, carrier.angular, atol=1e-12)
    np.testing.assert_allclose(tool.linear @ v, carrier.linear @ v + np.cross(carrier.angular @ v, arm), atol=1e-12)
    assert "tool" in with_tool.frame_names
    assert not robot.has_frame("tool")


@pytest.mark.parametrize("mimic", ["lock", "follow"])
def test_it_stays_in_copies_and_carries_others(mimic: str) -> None:
    panda = load_robot("panda", mimic=mimic, position_limit={"panda_joint1": (-1.0, 1.0)})
    robot = panda.with_frame("tool", on="panda_hand", at=[0.0, 0.0, 0.1])
    expected = robot.at(robot.home).frame("tool").position
    further = robot.with_frame("tip", on="tool", at=[0.0, 0.0, 0.1])
    np.testing.assert_array_equal(further.position_limit, panda.position_limit)
    for other in copy.copy(robot), copy.deepcopy(robot), pickle.loads(pickle.dumps(robot)), further:
        np.testing.assert_allclose(other.at(other.home).frame("tool").position, expected, atol=1e-12)
    hand = panda.at(panda.home).frame("panda_hand")
    tip = further.at(panda.home).frame("tip").position
    np.testing.assert_allclose(tip, hand.position + 0.2 * hand.rotation[:, 2], atol=1e-12)


def test_a_contact_on_it_is_one_with_its_centre_there() -> None:
    """In the rows, and in physics."""
    scene, at = quadruped(), (0.0, 0.0, -0.213)
    legs = [foot.frame.removesuffix("_foot") for foot in scene.feet]
    robot: PinocchioRobot = scene.robot
    for leg in legs:
        robot = robot.with_frame(f"{leg}_toe", on=f"{leg}_calf", at=at)
    toes = tuple(Contact(f"{leg}_toe", friction=0.6, name=leg) for leg in legs)
    points = tuple(Contact(f"{leg}_calf", centre=at, friction=0.6, name=leg) for leg in legs)
    steps, places = [], []
    for own, feet in (robot, toes), (scene.robot, points):
        here = scene._replace(robot=own, feet=feet)
        stack = here.limits >> CenterOfMassTask(np.add(scene.com, [0.01, 0.0, 0.0]), gain=5.0) >> here.rest("base")
        steps.append(Controller(own, stack, order="torque", dt=DT)(scene.q, scene.v))
        plant = MujocoPlant(own, contacts=feet)
        places.append(plant.advance(scene.q, scene.v, steps[-1].tau, DT)[0])
    np.testing.assert_allclose(steps[0].tau, steps[1].tau, atol=1e-8)
    np.testing.assert_allclose(places[0], places[1], atol=1e-10)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"name": "panda_hand"}, "'panda_hand' is a frame of the robot already"),
        ({"on": "panda_hnad"}, "panda_hand"),
        ({"at": [0.0, 1.0]}, r"at has shape \(2,\)"),
        ({"rotation": 2.0 * np.eye(3)}, "with_frame: rotation"),
        ({"name": 3}, "with_frame: name"),
    ],
)
def test_refusals(given: dict, named: str) -> None:
    with pytest.raises(InvalidInput, match=named):
        load_robot("panda").with_frame(**{"name": "tool", "on": "panda_hand", **given})
