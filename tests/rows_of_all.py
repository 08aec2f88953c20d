"""The rows of every part, and how they bend, on a planar arm, a Panda, a robot with unit circles and a humanoid, at all
orders.

Run as a program it writes them to a file: in an interpreter of its own, to compare with the rows of this one.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from live_table import GROUPS, SETTINGS, Setting

from hqp import InvalidInput
from tasks import JointVelocityLimit, Part, load_robot
from tasks.rows.plan import Plan

DT = 0.01
ORDERS: tuple[Any, ...] = ("velocity", "acceleration", "displacement")
#: Parts of these groups name frames of the Panda.
NAMED = ("distances",)
#: Gradients by differences of numbers divide their round-off by a step.
DIFFERENCES = ("difference", "gradient")


def settings() -> Iterator[tuple[str, Setting]]:
    for name, make in SETTINGS.items():
        yield name, make()
    rng = np.random.default_rng(3)
    for name, frame, tip in ("tiago", "arm_5_link", "arm_tool_link"), ("g1", "left_elbow_link", "right_elbow_link"):
        robot = load_robot(name, tip=tip, acceleration_limit=20.0)
        states = tuple((robot.random(rng), rng.uniform(-0.5, 0.5, robot.nv), t) for t in (0.3, 1.2))
        yield name, Setting(robot, frame, False, robot.home, states)


def parts() -> Iterator[tuple[str, Setting, Part]]:
    """Those that fit: a name, the setting, and the part."""
    for robot, setting in settings():
        for group, cases in GROUPS.items():
            if robot in SETTINGS or group not in NAMED:
                for k, case in enumerate(cases(setting)):
                    yield f"{robot}, {group} {k}, {case.spec.kind.__name__}", setting, case.spec.make({}, _as_it_is, {})


def rows_of_all() -> dict[str, np.ndarray]:
    """By part, order and how exact they are: A, lower, upper and the curvature, one after the other."""
    found = dict[str, np.ndarray]()
    for name, setting, part in parts():
        for order in ORDERS:
            try:
                rows = (JointVelocityLimit(2.0) >> part).build(setting.robot, order, DT)
            except InvalidInput:  # it does not fit the robot or the order
                continue
            plan = rows.plans[-1][1]
            said = " ".join(plan.why for _, plan in rows.plans)
            exact = "by differences" if any(word in said for word in DIFFERENCES) else "exact"
            numbers = [
                np.concatenate(
                    [filled.dense().ravel(), filled.lower, filled.upper, bend(plan, part.size(setting.robot))]
                )
                for q, v, t in setting.states
                for filled in [rows.fill(setting.robot.at(q, v), t)]
            ]
            found[f"{name}, {order}, {exact}"] = np.stack(numbers)
    return found


def bend(plan: Plan, rows: int) -> np.ndarray:
    return np.zeros(0) if plan.curvature is None else plan.curvature_of(np.linspace(-1.0, 1.0, rows)).ravel()


def _as_it_is(kind: Any) -> Any:
    return kind


if __name__ == "__main__":
    np.savez(sys.argv[1], **rows_of_all())
