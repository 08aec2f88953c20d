"""The rows of every part, and how they bend, on a planar arm, a Panda, a robot with unit circles and a humanoid, at all
orders.

Run as a program it writes them to a file: in an interpreter of its own, to compare with the rows of this one.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from live_table import GROUPS, SETTINGS, Setting

from hqp import InvalidInput
from tasks import (
    AxisTask,
    JointVelocityLimit,
    Line,
    LookAtTask,
    OrientationTask,
    Part,
    PlaneTask,
    PoseTask,
    PositionTask,
    Turn,
    load_robot,
)
from tasks.base.rotations import exp
from tasks.rows.plan import Plan

DT = 0.01
ORDERS: tuple[Any, ...] = ("velocity", "acceleration", "displacement")
#: What the rows of a frame may be seen from.
REFERENCES: tuple[Any, ...] = ("local_world_aligned", "local", "world")
#: Parts of these groups name frames of the Panda.
NAMED = ("distances",)
#: Gradients by differences of numbers divide their round-off by a step.
DIFFERENCES = ("difference", "gradient")


def settings(many: int = 2) -> Iterator[tuple[str, Setting]]:
    """Robots, each with so many random states."""
    rng = np.random.default_rng(3)
    for name, make in SETTINGS.items():
        own = make()
        yield name, replace(own, states=(*own.states, *states(own.robot, rng, many)))
    for name, frame, tip in ("tiago", "arm_5_link", "arm_tool_link"), ("g1", "left_elbow_link", "right_elbow_link"):
        robot = load_robot(name, tip=tip, acceleration_limit=20.0)
        yield name, Setting(robot, frame, False, robot.home, states(robot, rng, many))


def states(robot: Any, rng: np.random.Generator, many: int) -> tuple[Any, ...]:
    """Random positions, velocities and times."""

    def position() -> Any:
        return rng.uniform(*robot.position_limit) if robot.nq == robot.nv else robot.random(rng)

    times = rng.uniform(-0.2, 2.2, many)
    return tuple((position(), rng.uniform(-0.5, 0.5, robot.nv), float(t)) for t in times)


def placed(setting: Setting) -> Iterator[Part]:
    """Tasks of a frame: each kind, of the tip, of another frame and relative to it, seen from all, still and moving."""
    p, other = np.array([0.3, 0.2, 0.5]), np.array([0.4, -0.1, 0.3])
    R, turned = exp(np.array([0.3, -0.2, 0.5])), exp(np.array([0.1, 0.9, 0.2]))
    flat = {"target": p[:2]}, {"target": Line(p[:2], other[:2], 2.0)}
    still, moving = {"position": p, "rotation": R}, {"position": Line(p, other, 2.0), "rotation": Turn(R, turned, 2.0)}
    spatial: list[tuple[Any, tuple[dict[str, Any], ...], tuple[Any, ...]]] = [
        (PositionTask, ({"target": p}, {"target": moving["position"]}), REFERENCES),
        (OrientationTask, ({"target": R}, {"target": moving["rotation"]}), REFERENCES),
        (PoseTask, (still, moving), REFERENCES),
        (AxisTask, ({"direction": p}, {"direction": moving["position"]}), (None,)),
        (LookAtTask, ({"point": p}, {"point": moving["position"]}), (None,)),
        (PlaneTask, ({"distance": 0.1}, {"distance": Line([0.1], [0.3], 2.0)}), (None,)),
    ]
    planar = [(PositionTask, flat, REFERENCES[::2])]
    for kind, targets, references in planar if setting.flat else spatial:
        for place in {}, {"frame": setting.frame}, {"relative_to": setting.frame}:
            for seen, target in product(references, targets):
                normal = {"normal": [0.2, -0.3, 0.9]} if kind is PlaneTask else {}
                reference = {} if seen is None else {"reference": seen}
                yield kind(**target, **place, **normal, **reference, gain=2.0)


def parts(many: int = 2) -> Iterator[tuple[str, Setting, Part]]:
    """Those that fit: a name, the setting, and the part."""
    for robot, setting in settings(many):
        for group, cases in GROUPS.items():
            if robot in SETTINGS or group not in NAMED:
                for k, case in enumerate(cases(setting)):
                    yield f"{robot}, {group} {k}, {case.spec.kind.__name__}", setting, case.spec.make({}, _as_it_is, {})
        for k, part in enumerate(placed(setting)):
            yield f"{robot}, placed {k}, {type(part).__name__}", setting, part


def rows_of_all(many: int) -> dict[str, np.ndarray]:
    """By part, order and how exact they are: A, lower, upper and the curvature, one after the other."""
    found = dict[str, np.ndarray]()
    for name, setting, part in parts(many):
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
    np.savez(sys.argv[1], **rows_of_all(int(sys.argv[2])))
