"""Spraying a bent panel whose upper corners are out of reach: the gun square to it first, its place last."""

import sys
from itertools import pairwise

import numpy as np

from tasks import (
    AxisTask,
    Chain,
    Controller,
    Damping,
    JointLimits,
    JointVelocityLimit,
    Line,
    PositionTask,
    load_robot,
    quintic,
    simulate,
    solve_ik,
)

NEAR, BEND, MIDDLE, HALF = 0.45, 0.4, 0.25, 0.5  # of the panel [m]: distance, radius, height, half its width
LANES, LANE, TURN = 5, 4.0, 1.0  # how many, and how long one takes, and the way to the next [s]
robot = load_robot("ur5")

places, directions = [], []
for i, angle in enumerate(np.radians(np.linspace(35.0, -35.0, LANES))):
    for y in (HALF, -HALF) if i % 2 == 0 else (-HALF, HALF):
        places.append([NEAR + BEND * (1.0 - np.cos(angle)), y, MIDDLE + BEND * np.sin(angle)])
        directions.append([np.cos(angle), 0.0, -np.sin(angle)])  # into the panel, square to it


def lanes(points):
    """From one to the next: a lane, the way to the next lane, and so on."""
    return Chain([Line(a, b, TURN if i % 2 else LANE, quintic) for i, (a, b) in enumerate(pairwise(points))])


gun = PositionTask(lanes(places), gain=5.0, name="gun")
square = AxisTask(lanes(directions), gain=5.0, name="square")
orders = {"square first": square >> gun + Damping(0.02), "gun first": gun >> square + Damping(0.02)}
records = {}
for name, order in orders.items():
    stack = JointLimits(JointVelocityLimit(2.0)) >> order
    start = solve_ik(robot, order, [-0.6, -1.6, 2.0, -0.4, 1.0, 0.0], restarts=False).q
    record = records[name] = simulate(Controller(robot, stack, dt=0.01), start, duration=24.0, certify=50)
    off = 1e3 * np.linalg.norm(record.errors["gun"], axis=1)
    tilted = np.degrees(np.linalg.norm(record.errors["square"], axis=1))
    print(f"{name:12} gun off by at most {off.max():5.2f} mm, tilted by {tilted.max():5.2f} deg", end="; ")
    print(
        f"tilted by more than 1 deg for {np.mean(tilted > 1.0):4.0%}; {record.certified} of {record.checked} certified"
    )

if sys.argv[1:]:  # a folder, for the picture
    from _application_pictures import spraying

    spraying(sys.argv[1], robot, records, np.array(places))
