"""Arms, stacks and states for the tests of damping by curvature; run, it writes what a controller answers."""

from __future__ import annotations

import sys

import numpy as np

from tasks import (
    AtMost,
    Controller,
    Damped,
    JointLimits,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
)

DT = 0.01


def arm(seed):
    """A planar arm of three to six joints."""
    rng = np.random.default_rng(seed)
    return PlanarArm(rng.uniform(0.2, 0.6, int(rng.integers(3, 7))), position_limit=(-2.6, 2.6), velocity_limit=2.0)


def stack(robot, seed):
    """Two tasks in either order, the one with a target up to twice as far as the arm reaches, and a posture."""
    rng = np.random.default_rng(seed)
    reach, angle = rng.uniform(0.2, 2.0) * robot.lengths.sum(), rng.uniform(-np.pi, np.pi)
    place = PositionTask(reach * np.array([np.cos(angle), np.sin(angle)]), gain=float(rng.uniform(2.0, 30.0)))
    turn = OrientationTask(float(rng.uniform(-2.0, 2.0)), gain=5.0)
    posture = PostureTask(np.full(robot.nv, 0.3), gain=1.0)
    low = AtMost(PositionTask([0.2 * robot.lengths.sum()], mask="y", gain=5.0, name="ceiling"))
    kind = seed % 4
    first, second = (place, turn) if kind % 2 else (turn, place)
    if kind == 2:
        return JointLimits() >> first >> low >> second >> posture
    if kind == 3:
        return JointLimits() >> first >> Damped(second, None) >> posture
    return JointLimits() >> first >> second >> posture


def state(robot, seed):
    """One near to stretched, as often as not."""
    rng = np.random.default_rng(seed + 1000)
    q = rng.uniform(-1.0, 1.0, robot.nv) * rng.choice([0.02, 2.0])
    return q, rng.uniform(-1.0, 1.0, robot.nv)


def answers(seeds, backend="native"):
    """The answers of a new controller a seed, at three states one after the other."""
    found = []
    for seed in seeds:
        robot = arm(seed)
        controller = Controller(robot, stack(robot, seed), dt=DT, backend=backend)
        q, v = state(robot, seed)
        for _ in range(3):
            step = controller(q, v)
            found.append(step)
            q, v = q + DT * step.v, step.v
    return found


if __name__ == "__main__":
    np.savez(sys.argv[1], *(step.v for step in answers(range(int(sys.argv[2])))))
