"""How soon any motion within the joint speeds could have followed a target that has come back into reach."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from hqp.arrays import Array
from tasks.robots.robot import Robot

#: From how many configurations a nearer one is looked for.
STARTS = 4


def soonest(robot: Robot, frame: str, q: Array, targets: Array, within: Array, dt: float) -> float:
    """From when on some configuration that the joints can have reached by then is always near enough [s].

    In a time t joint i gets no farther than v_i t from where it is, nor out of its range. So a controller that knew the
    whole motion in advance could not have been with the target from any earlier time on, as far as all minima of the
    distance were found.

    Parameters
    ----------
    frame : str
        Of the hand.
    q : array, shape (nv,)
        Where the joints are when the target has come back.
    targets : array, shape (ticks, 3)
        From then until the hand is there [m].
    within : array, shape (ticks,)
        How near is near enough [m].
    dt : float
        [s].
    """
    still, rng = np.zeros(robot.nv), np.random.default_rng(0)
    least, most = robot.position_limit
    for k in reversed(range(len(targets))):
        way = k * dt * robot.velocity_limit + 1e-9  # the box must not be empty
        box = np.maximum(least, q - way), np.minimum(most, q + way)
        starts = [q, *rng.uniform(*box, size=(STARTS - 1, robot.nv))]
        far = (_nearest(robot, frame, np.clip(start, *box), targets[k], box, still) for start in starts)
        if all(distance > within[k] for distance in far):
            return (k + 1) * dt
    return 0.0


def _nearest(robot: Robot, frame: str, q: Array, target: Array, box: tuple[Array, Array], still: Array) -> float:
    """The distance at the next minimum within a box of configurations [m]."""
    found = least_squares(
        lambda q: robot.at(q, still).frame(frame).position - target,
        q,
        jac=lambda q: robot.at(q, still).frame(frame).linear,
        bounds=box,
    )
    return float(np.linalg.norm(found.fun))
