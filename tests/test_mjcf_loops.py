"""Closed chains of an MJCF: what MuJoCo measures of them is what a Loop measures, and stacks close them."""

from __future__ import annotations

import logging

import mujoco
import numpy as np
import pytest
from mjcf_idioms import FOUR_BARS, LOOPS

from hqp import InvalidInput
from tasks import Controller, Loop, PostureTask, Stack, load_robot, simulate
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
