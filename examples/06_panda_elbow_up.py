"""A Panda reaches out while its elbow stays up: an inequality above position, position above orientation."""

import sys

import numpy as np

from tasks import (
    AtLeast,
    Controller,
    Damping,
    JointLimits,
    Line,
    OrientationTask,
    PositionTask,
    load_robot,
    quintic,
    simulate,
)

ELBOW, LOWEST = "panda_link4", 0.55  # the frame, and the height [m] that it is to keep
robot = load_robot("panda", lock=["panda_finger_joint1"])
hand = robot.at(robot.home, np.zeros(robot.nv)).frame()  # the tip, panda_hand_tcp
path = Line(hand.position, [0.7, 0.3, 0.3], duration=2.0, timing=quintic)


def reach(*, elbow_up: bool) -> Controller:
    stack = JointLimits() >> PositionTask(path, gain=10.0)
    if elbow_up:
        elbow = PositionTask([LOWEST], frame=ELBOW, mask="z", gain=10.0, name="elbow")
        stack = JointLimits() >> AtLeast(elbow) >> PositionTask(path, gain=10.0)
    # Damped: with the elbow held the arm has no joint to spare, and the orientation goes out of reach.
    return Controller(robot, stack >> OrientationTask(hand.rotation, gain=10.0) + Damping(0.1), dt=0.01)


records = {}
for name, controller in ("elbow free", reach(elbow_up=False)), ("elbow up", reach(elbow_up=True)):
    record = records[name] = simulate(controller, robot.home, duration=3.0, certify=10)
    heights = np.array([robot.at(q, record.v[0]).frame(ELBOW).position[2] for q in record.q])
    errors = {task: np.linalg.norm(error, axis=1).max() for task, error in record.errors.items()}
    print(f"{name}: {record}")
    print(f"  lowest elbow {heights.min():.4f} m, largest errors:")
    print(f"  position {1e3 * errors['position']:.2f} mm, orientation {np.degrees(errors['orientation']):.1f} deg")

k = int(np.argmax(np.linalg.norm(records["elbow up"].errors["orientation"], axis=1) > np.radians(5.0)))
t = records["elbow up"].t[k]
print(f"\nat t = {t:.2f} s the orientation is 5 deg off. What holds it back?")
print(reach(elbow_up=True)(records["elbow up"].q[k], records["elbow up"].v[k], t).solution.explain())

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import panda_elbow

    panda_elbow(sys.argv[1], robot, records, ELBOW, LOWEST)
