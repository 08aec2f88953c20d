"""An arm reaches past an obstacle: with a limit on the distance, with a task that drives away, and with neither."""

import sys

import numpy as np

from tasks import (
    AvoidanceTask,
    Controller,
    DistanceLimit,
    JointVelocityLimit,
    Line,
    PlanarArm,
    PositionTask,
    Sphere,
    planar_links,
    quintic,
    simulate,
)

MARGIN, THICK = 0.03, 0.02  # [m]
arm = PlanarArm([0.35, 0.35, 0.35, 0.35, 0.3])
links, circle = planar_links(arm, THICK), Sphere([0.48, 0.42], 0.12)
start = np.radians([100.0, -40.0, -50.0, -45.0, -30.0])
path = Line(arm.pose(start)[:2], [0.5, 0.235], duration=3.0, timing=quintic)

limits, tip = JointVelocityLimit(2.0), PositionTask(path, gain=10.0)
distance = DistanceLimit(links, [circle], margin=MARGIN, gain=20.0)
away = AvoidanceTask(links, [circle], influence=0.12, speed=0.2)
stacks = {
    "nothing": limits >> tip,
    "task above the tip": limits >> away >> tip,
    "task below the tip": limits >> tip >> away,
    "limit above the tip": limits >> distance >> tip,
}

records, apart = {}, {}
for name, stack in stacks.items():
    controller = Controller(arm, stack, dt=0.01, damping=None)  # strict, as the laws of the literature are
    record = records[name] = simulate(controller, start, duration=4.0, certify=10)
    states = (arm.at(q, np.zeros(5)) for q in record.q)
    apart[name] = np.array([distance.distances(arm, state).min() for state in states])
    off = 1e3 * np.linalg.norm(record.errors["position"], axis=1)
    print(f"{name:20} nearest {1e3 * apart[name].min():7.2f} mm, tip off by at most {off.max():6.2f} mm,", end=" ")
    print(f"{record.certified} of {record.checked} ticks proved, fastest joint {np.abs(record.v).max():.2f} rad/s")

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import obstacle

    obstacle(sys.argv[1], arm, records, apart, circle, MARGIN)
