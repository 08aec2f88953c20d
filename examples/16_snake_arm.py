"""An arm of 14 links through a hole in a wall and up behind it: the tip follows its path, the body keeps clear."""

import sys
from itertools import pairwise

import numpy as np

from tasks import (
    Capsule,
    Chain,
    Controller,
    DistanceLimit,
    JointLimits,
    JointVelocityLimit,
    Line,
    PlanarArm,
    PositionTask,
    PostureTask,
    planar_links,
    quintic,
    simulate,
    solve_ik,
)

MARGIN, THICK, WALL = 0.01, 0.012, 0.02  # [m]: distance to keep, half thickness of the links and of the wall
HOLE, HALF = 0.65, 0.04  # [m]: where the hole is, about y = 0, and half its width
arm = PlanarArm(14 * [0.1])
walls = [Capsule([HOLE, side * (HALF + WALL)], [HOLE, side * 0.8], WALL) for side in (1.0, -1.0)]

before = PositionTask([0.5, 0.0], gain=1.0)  # in front of the hole, the arm arched above
arch = PostureTask(np.radians([120, -10, *8 * [-20], -10, 10, 20, 10]), gain=1.0)
start = solve_ik(arm, before >> arch).q
places = np.array([[0.5, 0.0], [0.65, 0.0], [0.8, 0.0], [0.85, 0.35]])  # [m]: through the hole, and up behind the wall
path = Chain([Line(a, b, 20.0 * np.linalg.norm(b - a), quintic) for a, b in pairwise(places)])  # 5 cm/s

limits, tip = JointLimits(JointVelocityLimit(0.3)), PositionTask(path, gain=10.0, name="tip")
clear = DistanceLimit(planar_links(arm, THICK), walls, margin=MARGIN, gain=10.0, nearest=8)
records, apart = {}, {}
for name, stack in ("tip alone", limits >> tip), ("body clear", limits >> clear >> tip):
    record = records[name] = simulate(Controller(arm, stack, dt=0.01), start, duration=13.0, certify=50)
    apart[name] = np.array([clear.distances(arm, arm.at(q, np.zeros(arm.nv))).min() for q in record.q])
    off = 1e3 * np.linalg.norm(record.errors["tip"], axis=1)
    print(f"{name:10} nearest {1e3 * apart[name].min():6.2f} mm, tip off by at most {off.max():.2f} mm", end=", ")
    print(f"at the end {off[-1]:.3f} mm; {record.certified} of {record.checked} certified")

if sys.argv[1:]:  # a folder, for the picture
    from _application_pictures import snake_arm

    snake_arm(sys.argv[1], arm, records, apart, walls, MARGIN)
