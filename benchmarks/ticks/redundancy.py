"""The cost of a tick with each secondary criterion: this library alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter_ns

import numpy as np

from tasks import (
    Circle,
    Controller,
    Damped,
    DistanceLimit,
    JointCentringTask,
    JointLimits,
    JointTorqueLimit,
    KineticEnergyTask,
    ManipulabilityTask,
    OrientationTask,
    Part,
    PinocchioRobot,
    PositionTask,
    PostureTask,
    SelfCollisionLimit,
    Sphere,
    Stack,
    load_robot,
)
from tasks.obstacles.links import LinkCapsule

from ..tables import Row

DT = 0.005


@dataclass(frozen=True)
class Bench:
    """The Panda of all stacks, its hand on a circle.

    Attributes
    ----------
    robot : PinocchioRobot
    hand, turn : Part
    """

    robot: PinocchioRobot
    hand: PositionTask
    turn: OrientationTask

    def rest(self) -> Part:
        """The posture that all begin with."""
        return PostureTask(self.robot.home, gain=1.0)


def bench() -> Bench:
    """Made anew: a robot belongs to one controller at a time."""
    robot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=15.0)
    tip = robot.at(robot.home, np.zeros(robot.nv)).frame()
    path = Circle(tip.position[:2] + np.array([0.08, 0.0]), 0.08, 10.0)

    def target(t: float):
        at, v, a = path(t)
        return np.array([*at, tip.position[2]]), np.array([*v, 0.0]), np.array([*a, 0.0])

    return Bench(robot, PositionTask(target, gain=4.0), OrientationTask(tip.rotation, gain=4.0))


def _obstacle(b: Bench) -> Stack:
    links = [LinkCapsule("panda_link3", "panda_link4", 0.08), LinkCapsule("panda_link5", "panda_link6", 0.07)]
    wall = DistanceLimit(links, [Sphere([0.3, 0.5, 0.5], 0.1)], margin=0.02, gain=20.0)
    return JointLimits() >> wall >> b.hand >> b.turn >> b.rest()


#: Name -> order, and the stack.
STACKS: dict[str, tuple[str, Callable[[Bench], Stack]]] = {
    "limits > hand > orientation > posture": ("velocity", lambda b: JointLimits() >> b.hand >> b.turn >> b.rest()),
    "the same at acceleration order": ("acceleration", lambda b: JointLimits() >> b.hand >> b.turn >> b.rest()),
    "the same at torque order, torques limited": (
        "torque",
        lambda b: JointTorqueLimit() >> JointLimits() >> b.hand >> b.turn >> b.rest(),
    ),
    "orientation damped": ("velocity", lambda b: JointLimits() >> b.hand >> Damped(b.turn, 0.1) >> b.rest()),
    "joints to their middles (Liegeois)": (
        "velocity",
        lambda b: JointLimits() >> b.hand >> b.turn >> JointCentringTask(gain=1.0),
    ),
    "manipulability": ("velocity", lambda b: JointLimits() >> b.hand >> b.turn >> ManipulabilityTask(b.hand, gain=1.0)),
    "least kinetic energy": ("velocity", lambda b: JointLimits() >> b.hand >> b.turn >> KineticEnergyTask()),
    "two links away from a sphere": ("velocity", _obstacle),
    "self-collision, meshes": (
        "velocity",
        lambda b: JointLimits() >> SelfCollisionLimit(margin=0.02, gain=20.0) >> b.hand >> b.turn >> b.rest(),
    ),
}


def costs(ticks: int) -> list[Row]:
    """A row a stack: what one call of its controller takes in closed loop."""
    rows = []
    for name, (order, declare) in STACKS.items():
        b = bench()
        times, ok = _run(Controller(b.robot, declare(b), order=order, dt=DT, damping=None), ticks)
        median, p90, p99 = np.percentile(times, [50, 90, 99])
        rows.append(
            {
                "method": name,
                "order": order,
                "median us": f"{median:.1f}",
                "p90 us": f"{p90:.1f}",
                "p99 us": f"{p99:.1f}",
                "optimal": f"{ok}/{ticks}",
            }
        )
    return rows


def _run(controller: Controller, ticks: int) -> tuple[np.ndarray, int]:
    """Times of all ticks [us], and how many answers are claimed."""
    robot = controller.robot
    q, v, times, ok = robot.home, np.zeros(robot.nv), np.empty(ticks), 0
    for k in range(ticks):
        start = perf_counter_ns()
        step = controller(q, v, k * DT)
        times[k] = (perf_counter_ns() - start) / 1000.0
        ok += step.ok
        if step.v is not None:
            v, dq = step.v, DT * step.v
        else:
            dq, v = DT * v + 0.5 * DT * DT * step.a, v + DT * step.a
        q = robot.integrate(q, dq)
    return times, ok
