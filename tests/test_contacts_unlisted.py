"""Robots that the library does not list stand, shift their weight and lift a foot: from their files, in ten lines."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import pytest
from contact_scenes import DT, Scene, advanced
from test_contacts import check_mechanics

from tasks import CenterOfMassTask, Contact, Controller, Line, MujocoPlant, PositionTask, load_robot, quintic
from tasks.robots.library import data_folder


class Given(NamedTuple):
    """A robot of example-robot-data, as a user would find it.

    Attributes
    ----------
    file : str
        Its URDF.
    feet : tuple of str
        The frames that touch the ground; the last one is lifted.
    trunk : str
    way : tuple of float
        Where the weight goes before [m].
    joints : dict
        How it stands, unless `srdf` says so: the file and the name of a configuration.
    sole : tuple of float, optional
        Lengths and places of a foot in its frame: x from, to, y from, to; a point if there is none.
    radius : float, optional
        Of wheels.
    """

    file: str
    feet: tuple[str, ...]
    trunk: str
    way: tuple[float, float, float]
    joints: Mapping[str, float] = MappingProxyType({})
    srdf: tuple[str, str] | None = None
    sole: tuple[float, float, float, float] | None = None
    radius: float | None = None


def _feet(names: str, suffix: str) -> tuple[str, ...]:
    return tuple(name + suffix for name in names.split())


def _bent(legs: str, hip: str, knee: str, angle: float) -> dict[str, float]:
    """Legs of a quadruped whose knees point to its middle, or all back."""
    turn = [angle if leg[1:2].lower() == "f" else -angle for leg in legs.split()]
    both = zip(legs.split(), turn, strict=True)
    return {leg + joint: a * share for leg, a in both for joint, share in ((hip, 1.0), (knee, -2.0))}


ANYMAL, HYQ, UNITREE = "LF RF LH RH", "lf rf lh rh", "FL FR RL RR"
ROBOTS = {
    "a1": Given(
        "a1_description/urdf/a1.urdf",
        _feet(UNITREE, "_foot"),
        "trunk",
        (0.02, 0.015, -0.02),
        srdf=("a1_description/srdf/a1.srdf", "standing"),
    ),
    "anymal": Given(
        "anymal_c_simple_description/urdf/anymal.urdf",
        _feet(ANYMAL, "_FOOT"),
        "base",
        (0.03, 0.02, -0.03),
        srdf=("anymal_c_simple_description/srdf/anymal.srdf", "standing"),
    ),
    "hyq": Given(
        "hyq_description/robots/hyq_no_sensors.urdf",
        _feet(HYQ, "_foot"),
        "trunk",
        (0.04, 0.03, -0.03),
        joints=_bent(HYQ, "_hfe_joint", "_kfe_joint", 0.75),
    ),
    "b1 with an arm": Given(
        "b1_description/urdf/b1-z1.urdf",
        _feet(UNITREE, "_foot"),
        "trunk",
        (0.04, 0.03, -0.03),
        srdf=("b1_description/srdf/b1-z1.srdf", "standing_with_arm_up"),
    ),
    "talos with all joints": Given(
        "talos_data/robots/talos_full_v2.urdf",
        ("left_sole_link", "right_sole_link"),
        "base_link",
        (0.0, 0.03, -0.03),
        srdf=("talos_data/srdf/talos.srdf", "half_sitting"),
        sole=(-0.1, 0.1, -0.06, 0.06),
    ),
    "icub": Given(
        "icub_description/robots/icub_reduced.urdf",
        ("l_sole", "r_sole"),
        "root_link",
        (0.0, 0.015, -0.02),
        srdf=("icub_description/srdf/icub.srdf", "half_sitting"),
        sole=(-0.04, 0.1, -0.02, 0.02),
    ),
    "centauro on wheels": Given(
        "centauro_description/urdf/centauro.urdf",
        tuple(f"wheel_{i}" for i in (1, 2, 3, 4)),
        "pelvis",
        (0.08, 0.04, -0.03),
        srdf=("centauro_description/srdf/centauro.srdf", "homing_nominal"),
        radius=0.078,
    ),
}


def standing(given: Given) -> Scene:
    robot = load_robot(data_folder() / given.file, base="floating", acceleration_limit=50.0)
    if given.srdf is None:
        q = robot.configuration(given.joints)
    else:
        q = robot.with_srdf(data_folder() / given.srdf[0]).configuration(given.srdf[1])
    state = robot.at(q, np.zeros(robot.nv))
    options: dict[str, object] = {"radius": given.radius}
    if given.sole is not None:
        x0, x1, y0, y1 = given.sole
        options = {"plane": (x1 - x0, y1 - y0), "centre": (0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0)}
    feet = tuple(Contact(frame, friction=0.6, **options) for frame in given.feet)  # type: ignore[arg-type]
    com, up = state.center_of_mass.position.copy(), state.frame(given.trunk).rotation.copy()
    return Scene(robot, q, com, up, feet)


@pytest.mark.parametrize("name", ROBOTS)
def test_it_stands_on_what_its_file_says(name: str) -> None:
    given = ROBOTS[name]
    scene = standing(given)
    robot, last = scene.robot, given.feet[-1]
    there, foot = scene.com + given.way, robot.at(scene.q).frame(last).position.copy()
    com = CenterOfMassTask(Line(scene.com, there, duration=0.5, timing=quintic), gain=6.0)
    swing = PositionTask(foot, frame=last, gain=20.0)
    tasks = com if len(given.feet) == 2 else com + swing
    controller = Controller(robot, scene.limits >> tasks >> scene.rest(given.trunk), order="torque", dt=DT)
    q, v, biped = scene.q, scene.v, len(given.feet) == 2
    for k in range(500):
        if k == 260 and not biped:
            controller.release(last, duration=0.05)
        if k == 320:
            swing.target = foot + np.array([0.0, 0.0, 0.01])
        step = controller(q, v, k * DT)
        assert step.ok
        if k % 50 == 0:
            assert step.solution.certify().ok
            check_mechanics(scene, q, v, step)
        q, v = advanced(robot, q, v, step.a)
        low, high = robot.position_limit[:, 6:]
        joints = robot.at(q, v).joints[6:]
        assert np.maximum(low - joints, joints - high).max() < 1e-9
    state = robot.at(q, v)
    assert np.linalg.norm(state.center_of_mass.position - there) < 1e-4
    if not biped:
        assert state.frame(last).position[2] - foot[2] > 0.005


def test_links_may_be_called_as_joints() -> None:
    """Those of an ANYmal are; with all joints held, its points stay where they are."""
    pytest.importorskip("mujoco", reason="physics need MuJoCo: pip install 'hqp[mujoco]'")
    scene = standing(ROBOTS["anymal"])
    assert "RH_KFE" in scene.robot.joint_names
    assert scene.robot.has_frame("body:RH_KFE")
    assert MujocoPlant(scene.robot, contacts=scene.feet).creep(scene.q, 0.5) < 1e-5
