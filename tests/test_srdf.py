"""Groups and configurations of an SRDF: Pinocchio reads the same positions, and what is wrong is said."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio as pin
import pytest

from hqp import InvalidInput
from tasks import Controller, Freeze, JointLimits, PositionTask, SelfCollisionLimit, load_robot

PANDA = load_robot("panda", lock=["panda_finger_joint1"])
TALOS = load_robot("talos")


@pytest.fixture
def srdf(tmp_path):
    def written(text: str):
        path = tmp_path / "robot.srdf"
        path.write_text(f'<?xml version="1.0"?><robot name="robot">{text}</robot>')
        return path

    return written


ARM = '<group name="arm"><chain base_link="panda_link0" tip_link="panda_hand"/></group>'
READY = '<group_state name="ready" group="arm"><joint name="panda_joint4" value="-1.5"/></group_state>'


def test_a_group_state_is_a_configuration_by_name(srdf) -> None:
    robot = PANDA.with_srdf(srdf(ARM + READY))
    assert robot.configurations == ("ready",)
    np.testing.assert_array_equal(robot.configuration("ready"), PANDA.configuration({"panda_joint4": -1.5}))
    np.testing.assert_array_equal(robot.home, PANDA.home)
    assert PANDA.configurations == ()
    for other in copy.copy(robot), copy.deepcopy(robot), pickle.loads(pickle.dumps(robot)), robot.with_capsules():
        np.testing.assert_array_equal(other.configuration("ready"), robot.configuration("ready"))
        assert other.groups == robot.groups


def test_positions_are_those_that_pinocchio_reads(srdf) -> None:
    """Of a floating base, of joints, and of a state in two parts."""
    path = srdf(
        '<group_state name="half" group="a"><joint name="root_joint" value="0. 0. 1.02 0. 0. 0.6 0.8"/>'
        '<joint name="leg_left_4_joint" value="0.8"/><joint name="leg_right_4_joint" value="0.7"/></group_state>'
    )
    model = pin.Model(TALOS.model)
    pin.loadReferenceConfigurations(model, str(path), False)
    theirs = np.array(model.referenceConfigurations["half"])
    np.testing.assert_allclose(TALOS.with_srdf(path).configuration("half"), theirs, atol=1e-12)


def test_a_joint_without_end_stands_at_its_angle(srdf) -> None:
    robot = load_robot("double_pendulum_continuous")
    name = robot.joint_names[0]
    path = srdf(f'<group_state name="up" group="all"><joint name="{name}" value="2.5"/></group_state>')
    expected = robot.configuration({name: 2.5})
    np.testing.assert_allclose(robot.with_srdf(path).configuration("up"), expected, atol=1e-12)


def test_states_of_two_groups_are_one_unless_they_contradict_each_other(srdf) -> None:
    other = '<group_state name="ready" group="wrist"><joint name="panda_joint6" value="2"/></group_state>'
    robot = PANDA.with_srdf(srdf(READY + other))
    expected = PANDA.configuration({"panda_joint4": -1.5, "panda_joint6": 2.0})
    np.testing.assert_array_equal(robot.configuration("ready"), expected)
    against = '<group_state name="ready" group="elbow"><joint name="panda_joint4" value="-1"/></group_state>'
    robot = PANDA.with_srdf(srdf(READY + against))
    assert robot.configurations == ("arm/ready", "elbow/ready")
    with pytest.raises(InvalidInput, match="did you mean 'arm/ready'"):
        robot.configuration("ready")


def test_groups_by_joints_links_chains_and_groups(srdf) -> None:
    robot = PANDA.with_srdf(
        srdf(
            ARM
            + '<group name="wrist"><link name="panda_link7"/><joint name="panda_joint6"/>'
            + '<link name="panda_hand"/></group>'
            + '<group name="upper"><chain base_link="panda_link0" tip_link="panda_link3"/></group>'
            + '<group name="both"><group name="upper"/><group name="wrist"/></group>'
            + '<group name="fingers"><joint name="panda_finger_joint1"/></group>'
        )
    )
    joints = [f"panda_joint{i}" for i in range(1, 8)]
    assert robot.groups == {
        "arm": tuple(joints),
        "wrist": ("panda_joint6", "panda_joint7"),
        "upper": tuple(joints[:3]),
        "both": (*joints[:3], *joints[5:]),
        "fingers": (),
    }
    stack = JointLimits() >> Freeze(all_but=robot.groups["wrist"]) >> PositionTask([0.4, 0.1, 0.4], gain=5.0)
    v = Controller(robot, stack, dt=0.01)(robot.home).v
    assert np.abs(v[:5]).max() < 1e-9 < np.abs(v[5:]).max()


def test_what_the_robot_has_not_is_told(srdf, caplog) -> None:
    state = '<group_state name="ready" group="arm"><joint name="elbow" value="1"/></group_state>'
    robot = PANDA.with_srdf(srdf(ARM + state + '<group name="fingers"><joint name="panda_finger_joint1"/></group>'))
    assert caplog.text.count("names what the robot has not: elbow\n") == 1  # a finger that is held, it has
    np.testing.assert_array_equal(robot.configuration("ready"), PANDA.neutral)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no group and no group_state"),
        ("<group><joint/></group>", "a group has no name"),
        ('<group name="a"><joint/></group>', "a joint has no name"),
        ('<group name="a"><chain base_link="panda_link0"/></group>', "a chain has no tip_link"),
        ('<group name="a"><group name="b"/></group>', "'b', which is no group"),
        ('<group name="a"><group name="b"/></group><group name="b"><group name="a"/></group>', "part of itself"),
        ('<group_state name="a"><joint name="panda_joint1" value="nan"/></group_state>', "'nan'; it must be numbers"),
        ('<group_state name="a"><joint name="panda_joint1" value="up"/></group_state>', "'up'; it must be numbers"),
        ('<group_state name="a"><joint name="panda_joint1" value="1_0"/></group_state>', "'1_0'; it must be numbers"),
        (
            '<group_state name="a"><joint name="panda_joint1" value="0 0"/></group_state>',
            "has 2 numbers; it must have 1",
        ),
        ('<group_state name="a"><joint name="panda_joint1"/></group_state>', "a joint has no value"),
        (
            '<group_state name="a"><joint name="panda_joint1" value="0"/><joint name="panda_joint1" value="1"/>'
            "</group_state>",
            "puts 'panda_joint1' at two positions",
        ),
        ('<group name="arm"><joint name="shoulder_pan_joint"/><link name="wrist"/></group>', "it is of another one"),
        ("<group", "no valid XML"),
        (READY + READY.replace("-1.5", "-1"), "group 'arm' has two group_states 'ready'"),
    ],
)
def test_what_is_wrong_is_refused_in_words(srdf, text, words) -> None:
    with pytest.raises(InvalidInput) as refusal:
        PANDA.with_srdf(srdf(text))
    assert words in str(refusal.value)
    assert "robot.srdf" in str(refusal.value)


def test_a_position_outside_a_range_is_told(srdf, caplog) -> None:
    """As degrees are."""
    robot = PANDA.with_srdf(srdf(ARM + READY.replace("-1.5", "-90")))
    assert "'ready' is outside the range of panda_joint4 [rad], [m]; it is moved into it" in caplog.text
    assert robot.configuration("ready")[3] == PANDA.position_limit[0, 3]
    caplog.clear()
    PANDA.with_srdf(srdf(ARM + READY))
    PANDA.with_srdf(srdf(ARM.replace("arm", "legs") + READY))
    assert caplog.text.count("\n") == 1
    assert "group arm" in caplog.text


def test_a_chain_leads_either_way(srdf) -> None:
    turned = '<group name="arm"><chain base_link="panda_hand" tip_link="panda_link0"/></group>'
    assert PANDA.with_srdf(srdf(turned)).groups == PANDA.with_srdf(srdf(ARM)).groups


def test_a_group_that_there_is_not_is_refused(srdf) -> None:
    groups = PANDA.with_srdf(srdf(ARM)).groups
    with pytest.raises(InvalidInput, match="'amr' is no group of the robot; did you mean 'arm'"):
        groups["amr"]
    assert "legs" not in groups
    assert groups.get("legs") is None


def test_no_file_is_refused(tmp_path) -> None:
    with pytest.raises(InvalidInput, match="cannot be read"):
        PANDA.with_srdf(tmp_path / "none.srdf")
    with pytest.raises(InvalidInput, match="file"):
        PANDA.with_srdf(3)


def test_an_srdf_is_no_robot(srdf) -> None:
    with pytest.raises(InvalidInput, match="with_srdf"):
        load_robot(srdf(ARM + READY))


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("<group ", "<gruop "), ("<group_state", "<group_sate"), ("<joint", "<jont"), ("<chain", "<chian")],
)
def test_elements_that_are_misspelt_are_refused(srdf, right: str, wrong: str) -> None:
    text = (
        (ARM + READY).replace(right, wrong).replace(right.replace("<", "</").strip() + ">", f"</{wrong[1:].strip()}>")
    )
    with pytest.raises(InvalidInput, match=f"{wrong.strip()}> of .* is not read; write {right.strip()}>"):
        PANDA.with_srdf(srdf(text))


def test_a_chain_may_go_up_and_down_again(srdf) -> None:
    """From one hand to the other, and from either end of an arm."""
    ends = {"both": ("arm_left_7_link", "arm_right_7_link"), "down": ("arm_left_7_link", "torso_2_link")}
    text = "".join(
        f'<group name="{name}"><chain base_link="{base}" tip_link="{tip}"/></group>'
        for name, (base, tip) in ends.items()
    )
    groups = TALOS.with_srdf(srdf(text)).groups
    arms = {side: {name for name in TALOS.joint_names if name.startswith(f"arm_{side}_")} for side in ("left", "right")}
    assert set(groups["down"]) == arms["left"]
    assert set(groups["both"]) == arms["left"] | arms["right"]


def test_a_group_without_joints_is_told(srdf, caplog) -> None:
    with caplog.at_level("WARNING", logger="hqp"):
        PANDA.with_srdf(srdf('<group name="nothing"><link name="panda_link0"/></group>' + ARM))
    assert "groups without a joint that moves: nothing" in caplog.text


@pytest.mark.parametrize("name", ["nowhere.srdf", "\ud800.srdf", "a\0b.srdf", "."])
def test_a_file_that_cannot_be_read_is_refused(name: str) -> None:
    for read in PANDA.with_srdf, lambda given: SelfCollisionLimit(without=given, margin=0.01, gain=10.0):
        with pytest.raises(InvalidInput, match="read"):
            read(name)
