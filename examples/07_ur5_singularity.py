"""A UR5 through its wrist singularity: what a limit on the speed costs, and which task pays."""

import sys

import numpy as np

from tasks import (
    Controller,
    Damping,
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


def run(limited: bool, strict: bool, damped: bool):
    position, orientation = PositionTask(path, gain=5.0), OrientationTask(hand.rotation, gain=5.0)
    last = orientation + Damping(0.1) if damped else orientation
    stack = position >> last if strict else position + last
    if limited:
        stack = JointLimits(JointVelocityLimit(FASTEST)) >> stack
    return simulate(Controller(robot, stack, dt=5e-3), start, duration=4.0, certify=20)


records = {
    "strict, no limits": run(limited=False, strict=True, damped=False),
    "strict": run(limited=True, strict=True, damped=False),
    "strict, damped": run(limited=True, strict=True, damped=True),
    "one level": run(limited=True, strict=False, damped=False),
    "one level, damped": run(limited=True, strict=False, damped=True),
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
