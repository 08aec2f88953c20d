"""A UR5 through its wrist singularity: what a limit on the speed costs, and which task pays."""

import sys

import numpy as np

from tasks import (
    Controller,
    JointLimits,
    JointVelocityLimit,
    Line,
    OrientationTask,
    PositionTask,
    load_robot,
    quintic,
    simulate,
)

FASTEST = 2.0  # [rad/s]
robot = load_robot("ur5")
start = np.array([0.0, -1.2, 1.6, -0.45, -0.4, 0.0])
hand = robot.at(start, np.zeros(6)).frame()
# A straight line on which wrist 2 comes within 1.2 degrees of 0, where wrists 1 and 3 turn about the same axis.
path = Line(hand.position, np.add(hand.position, [-0.1, 0.4, 0.0]), duration=3.0, timing=quintic)


def run(limited: bool, levels: bool, **options):
    position, orientation = PositionTask(path, gain=5.0), OrientationTask(hand.rotation, gain=5.0)
    stack = position >> orientation if levels else position + orientation
    if limited:
        stack = JointLimits(JointVelocityLimit(FASTEST)) >> stack
    return simulate(Controller(robot, stack, dt=5e-3, **options), start, duration=4.0, certify=20)


records = {
    "strict, no limits": run(limited=False, levels=True, damping=None),
    "strict": run(limited=True, levels=True, damping=None),
    "default": run(limited=True, levels=True),
    "one level, strict": run(limited=True, levels=False, damping=None),
    "one level": run(limited=True, levels=False),
}
print(f"{'largest of the run':18}  position [mm]  orientation [deg]  joint speed [rad/s]  certified")
for name, record in records.items():
    away, turn = (np.linalg.norm(record.errors[task], axis=1).max() for task in ("position", "orientation"))
    print(
        f"{name:18}  {1e3 * away:13.2f}  {np.degrees(turn):17.2f}  {np.abs(record.v).max():19.2f}"
        f"  {record.certified:3} of {record.checked}"
    )

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import ur5_singularity

    ur5_singularity(sys.argv[1], records, FASTEST)
