"""Closed chains of an MJCF: what MuJoCo measures of them is what a Loop measures, and stacks close them."""

from __future__ import annotations

import logging

import mujoco
import numpy as np
import pytest
from mjcf_idioms import FOUR_BARS, LOOPS

from hqp import InvalidInput
from tasks import Controller, Loop, PositionTask, PostureTask, Stack, load_robot, simulate
from tasks.base.rotations import log
from tasks.contacts.loop import LoopMotion


@pytest.mark.parametrize("name", LOOPS)
def test_loops_measure_what_mujoco_does(name) -> None:
    mj = mujoco.MjModel.from_xml_string(FOUR_BARS.format(LOOPS[name]))
    robot, data, rng = load_robot(mj), mujoco.MjData(mj), np.random.default_rng(1)
    (loop,) = Loop.of(robot)
    task, welded = LoopMotion(loop), "weld" in LOOPS[name]
    for _ in range(3):
        data.qpos[:] = rng.uniform(-1.0, 1.0, mj.nq)
        mujoco.mj_forward(mj, data)
        e = task.error(robot.at(data.qpos), 0.0)
        np.testing.assert_allclose(e[:3], -data.efc_pos[:3], atol=1e-12)
        assert len(e) == len(data.efc_pos) == (6 if welded else 3)
        if welded:  # of a turn by an angle, MuJoCo has the half of its sine, along axes of its own
            angle = np.linalg.norm(e[3:])
            np.testing.assert_allclose(abs(np.sin(angle / 2.0)), np.linalg.norm(data.efc_pos[3:]), atol=1e-9)


@pytest.mark.parametrize("order", ["velocity", "acceleration"])
@pytest.mark.parametrize("name", ["points", "a point of the world"])
def test_stacks_close_them(name, order) -> None:
    robot = load_robot(mujoco.MjModel.from_xml_string(FOUR_BARS.format(LOOPS[name])))
    start = np.array([0.4, 0.9, 1.1])
    stack = Stack(*Loop.of(robot, gain=10.0)) >> PostureTask(start, gain=1.0)
    record = simulate(Controller(robot, stack, order=order, dt=0.005), start, duration=2.0)
    error = LoopMotion(Loop.of(robot)[0]).error(robot.at(record.q[-1]), 0.0)
    assert np.abs(error).max() < 1e-3


#: A planar four-bar on the forearm of an arm in space, its pin told by three rows, of which one is across its plane.
CARRIED = """
<mujoco><compiler angle="radian"/><default><joint range="-3 3"/><geom size=".01"/></default><worldbody>
  <body name="base"><geom/>
  <body pos="0 0 .1"><joint name="pan" axis="0 0 1"/><geom/><body pos="0 0 .3"><joint name="lift" axis="0 1 0"/>
    <geom/><body pos="0 0 .4"><joint name="elbow" axis="0 1 0"/><geom/><site name="tip" pos=".3 0 .1"/>
      <body name="crank" pos="0 0 .1"><joint name="crank" axis="0 1 0"/><geom/>
        <body name="coupler" pos="0 0 .1"><joint name="coupler" axis="0 1 0"/><geom/></body></body>
      <body name="rocker" pos=".1 0 .1"><joint name="rocker" axis="0 1 0"/><geom/></body>
</body></body></body></body></worldbody>
<equality><connect body1="coupler" body2="rocker" anchor=".1 0 0"/></equality></mujoco>"""


@pytest.mark.parametrize("options", [{}, {"damping": None}], ids=["default", "strict"])
def test_a_chain_takes_nothing_from_the_joints_that_carry_it(options) -> None:
    """Differences of columns that are the same are zero, not round-off, which would be rows."""
    robot = load_robot(mujoco.MjModel.from_xml_string(CARRIED), tip="tip", velocity_limit=2.0)
    q = robot.configuration({"lift": 0.5, "elbow": 1.0, "crank": 0.3, "coupler": -0.3, "rocker": 0.3})
    reach = PositionTask(robot.at(q).frame().position + np.array([0.0, 0.02, 0.0]), gain=5.0)
    closed = Controller(robot, Stack(*Loop.of(robot)) >> reach >> PostureTask(q, gain=1.0), dt=5e-3, **options)(q)
    free = Controller(robot, reach >> PostureTask(q, gain=1.0), dt=5e-3, **options)(q)
    np.testing.assert_allclose(closed.v, free.v, atol=1e-9)
    assert [level.rank for level in closed.solution.levels] == [2, 3, 1]


def test_that_there_are_loops_is_told(caplog, nothing_told) -> None:
    with caplog.at_level(logging.WARNING, logger="hqp"):
        load_robot(mujoco.MjModel.from_xml_string(FOUR_BARS.format(LOOPS["points"])))
    assert "Loop.of(robot): loop" in caplog.text


def test_a_rotation_of_a_loop_is_kept_from_the_start_and_live() -> None:
    text = FOUR_BARS.format(LOOPS["bodies, welded"])
    robot = load_robot(mujoco.MjModel.from_xml_string(text))
    (loop,) = Loop.of(robot)
    state = robot.at([0.1, 0.2, 0.5])
    a, b = state.frame(loop.a).rotation, state.frame(loop.b).rotation
    e = LoopMotion(loop).error(state, 0.0)
    np.testing.assert_allclose(e[3:], log(b @ loop.rotation @ a.T), atol=1e-12)
    loop.rotation = b.T @ a
    np.testing.assert_allclose(LoopMotion(loop).error(state, 0.0)[3:], 0.0, atol=1e-12)


def test_what_is_wrong_is_refused_in_words() -> None:
    with pytest.raises(InvalidInput, match="give turns=False"):
        Loop("one", "two", rotation=np.eye(3))
    nameless = FOUR_BARS.format(LOOPS["sites"]).replace('name="two"', "")
    with pytest.raises(InvalidInput, match="give it a name"):
        load_robot(mujoco.MjModel.from_xml_string(nameless))


ACTUATED = '</equality><actuator><motor joint="a"/></actuator>'


def test_joints_of_a_chain_on_which_no_actuator_acts_are_told() -> None:
    """Their torques would be counted as a motor's, and nothing else in the file says that they have none."""
    text = FOUR_BARS.format(LOOPS["points"])
    told = load_robot(mujoco.MjModel.from_xml_string(text.replace("</equality>", ACTUATED))).left_out
    assert told == ("that no actuator drives the joints b, c (a torque_limit of 0 of each says so)",)
    assert load_robot(mujoco.MjModel.from_xml_string(text)).left_out == ()
    pulled = (
        '</equality><tendon><fixed name="t"><joint joint="b" coef="1"/></fixed></tendon><actuator><motor tendon="t"/>'
    )
    both = text.replace("</equality>", f'{pulled}<motor joint="a"/></actuator>')
    told = load_robot(mujoco.MjModel.from_xml_string(both)).left_out
    assert told == ("that no actuator drives the joints c (a torque_limit of 0 of each says so)",)


def test_a_limit_of_a_ball_is_of_all_its_axes() -> None:
    text = FOUR_BARS.format(LOOPS["points"]).replace('<joint name="b"/>', '<joint name="b" type="ball"/>')
    robot = load_robot(
        mujoco.MjModel.from_xml_string(text), torque_limit={"b": 0.0, "a": 9.0}, acceleration_limit={"b": 5.0}
    )
    np.testing.assert_array_equal(robot.torque_limit, [9.0, 0.0, 0.0, 0.0, np.inf])
    np.testing.assert_array_equal(robot.acceleration_limit, [np.inf, 5.0, 5.0, 5.0, np.inf])
    one = load_robot(mujoco.MjModel.from_xml_string(text), torque_limit={"b[1]": 3.0})
    np.testing.assert_array_equal(one.torque_limit, [np.inf, np.inf, 3.0, np.inf, np.inf])
