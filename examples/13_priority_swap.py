"""Two tasks that cannot both be met change places while a Panda moves: at once, and over half a second."""

import sys

import numpy as np

from tasks import (
    Change,
    Controller,
    JointLimits,
    Line,
    PositionTask,
    PostureTask,
    Record,
    load_robot,
    quintic,
    simulate,
)

AT, OVER, AT_ONCE = 1.0, 0.5, 1e-9  # when, and how long it takes [s]
robot = load_robot("panda", lock=["panda_finger_joint1"])
tip = robot.at(robot.home, np.zeros(robot.nv)).frame()
path = Line(tip.position, tip.position + np.array([0.2, 0.3, -0.1]), 3.0, quintic)
hand = PositionTask(path, gain=5.0, name="hand")
rest = PostureTask(robot.home, gain=3.0, name="rest")  # all joints: above the hand it leaves nothing to it
stack = JointLimits() >> hand >> rest
swapped = stack.swapped(hand, rest)


def run(*changes: Change) -> Record:
    controller = Controller(robot, stack, dt=0.005)
    record = simulate(controller, robot.home, duration=3.0, changes=changes)
    steps = np.abs(np.diff(record.v[2:], axis=0)).max(axis=1)  # the start from rest left out
    errors = {name: np.linalg.norm(error[-1]) for name, error in record.errors.items()}
    print(f"  largest step of a joint velocity {steps.max():.4f} rad/s, at t = {record.t[2 + steps.argmax()]:.2f} s")
    print(f"  at the end: hand off by {1e3 * errors['hand']:.1f} mm, rest by {np.degrees(errors['rest']):.1f} deg")
    return record


print("no change")
records = {"no change": run()}
print("at once")
records["at once"] = run(Change(AT, swapped, AT_ONCE))
print(f"over {OVER:g} s")
records["smooth"] = run(Change(AT, swapped, OVER))

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import priority_swap

    priority_swap(sys.argv[1], records, AT, OVER)
