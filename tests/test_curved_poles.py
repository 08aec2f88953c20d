"""Poles of the closed loop about rest: out of reach joints come to rest, and what swings there dies away."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tasks import Controller, JointLimits, OrientationTask, PositionTask, PostureTask, load_robot
from tasks.robots.pinocchio import PinocchioRobot

DT, GAIN = 0.005, 20.0
#: Of each robot: how far forwards the end of its reach is from its home [m], and the least damping ratio of any pole.
ROBOTS = {"panda": (0.45, 0.6), "ur5": (0.33, 0.25)}


def poles(robot: PinocchioRobot, target: np.ndarray, turn: float) -> np.ndarray:
    """Logarithms of the eigenvalues of a tick about rest, by central differences in q and v [1/s]."""
    to = Rotation.from_rotvec([0.0, turn, 0.0]).as_matrix() @ robot.at(robot.home, np.zeros(robot.nv)).frame().rotation
    stack = JointLimits() >> PositionTask(target, gain=GAIN) >> OrientationTask(to, gain=GAIN)
    controller, n = Controller(robot, stack >> PostureTask(robot.home, gain=1.0), dt=DT), robot.nv
    q, v = robot.home, np.zeros(n)
    for _ in range(4000):  # on its way round-off may lead the arm out of its plane, to which it comes back slowly
        v = controller(q, v).v
        q = robot.integrate(q, DT * v)
    assert np.abs(v).max() < 1e-8
    far, ways = 1e-6, np.eye(n)
    by_q, by_v = (
        np.transpose([(controller(*ahead(far * w)).v - controller(*ahead(-far * w)).v) / (2.0 * far) for w in ways])
        for ahead in (lambda dq: (robot.integrate(q, dq), np.zeros(n)), lambda dv: (q, dv))
    )
    return np.log(np.linalg.eigvals(np.block([[np.eye(n) + DT * by_q, DT * by_v], [by_q, by_v]])).astype(complex)) / DT


@pytest.mark.parametrize("turn", [0.0, 0.5], ids="{:g} rad".format)
@pytest.mark.parametrize("beyond", [0.02, 0.05], ids="{:g} m".format)
@pytest.mark.parametrize("name", ROBOTS)
def test_what_swings_at_the_end_of_reach_is_damped(name: str, beyond: float, turn: float) -> None:
    robot = load_robot(name, lock=["panda_finger_joint1"] if name == "panda" else ())
    (forwards, ratio), start = ROBOTS[name], robot.at(robot.home, np.zeros(robot.nv)).frame().position
    level = start * [1.0, 1.0, 0.0]
    found = poles(robot, start + (forwards + beyond) / np.linalg.norm(level) * level, turn)
    assert found.real.max() < -0.5
    assert (-found.real / np.abs(found)).min() > ratio


@pytest.mark.parametrize("share", [0.4, 0.6, 1.0], ids="{:g} of the error a tick".format)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["ur5", "ur10"])
def test_out_of_reach_joints_come_to_rest_at_gains_up_to_one_over_the_tick(name: str, seed: int, share: float) -> None:
    """Position and orientation out of reach: joints went from one speed limit to the other in every tick."""
    robot, rng, dt = load_robot(name), np.random.default_rng(seed), 0.01
    way = rng.normal(size=3) * [1.0, 1.0, 0.5]
    here = robot.at(robot.home, np.zeros(robot.nv)).frame()
    to = Rotation.from_rotvec(0.8 * rng.normal(size=3)).as_matrix() @ here.rotation
    stack = (
        JointLimits()
        >> PositionTask(2.2 * way / np.linalg.norm(way), gain=share / dt)
        >> OrientationTask(to, gain=share / dt)
        >> PostureTask(robot.home, gain=1.0)
    )
    controller, q, v, jump = Controller(robot, stack, dt=dt), robot.home, np.zeros(robot.nv), np.inf
    for _ in range(600):
        step = controller(q, v)
        jump = float(np.abs(step.v - v).max())
        q, v = robot.integrate(q, dt * step.v), step.v
    assert jump < 0.05
    assert np.abs(v).max() < 0.05
