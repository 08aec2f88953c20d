"""An arm follows a target that swings: UR3, UR5 or Kinova Gen2.

Pink: ``arm_ur3.py``, ``arm_ur3_sparse_solver.py``, ``arm_ur5.py``, ``arm_kinova_gen2.py``; mink: ``arm_ur5e.py``.
The target is told with its velocity, so that the hand is on it and not behind it. Position, orientation and posture are
levels: no cost is chosen. There is one solver for all sizes, sparse or not.
"""

import sys

from _common import Swing, off

from tasks import Controller, JointLimits, OrientationTask, PositionTask, PostureTask, load_robot, simulate

BENT = {"shoulder_pan_joint": 1.0, "shoulder_lift_joint": -1.0, "elbow_joint": 1.0}
KINOVA = {"j2s6s200_joint_2": 2.0, "j2s6s200_joint_3": 1.0, "j2s6s200_joint_5": 1.0}
ARMS = {  # where it starts, the frame that follows, the middle of the swing [m]
    "ur3": (BENT, "tool0", 0.3),
    "ur5": (BENT, "tool0", 0.5),
    "kinova": (KINOVA, "j2s6s200_end_effector", 0.5),
}

for name in sys.argv[1:] or ARMS:
    start, frame, middle = ARMS[name]
    robot = load_robot(name, tip=frame)
    q = robot.configuration(start)
    hand = robot.at(q).frame()
    target = Swing([hand.position[0], middle, 0.2], [0.0, 0.1, 0.0], 2.0)
    stack = JointLimits() >> PositionTask(target, gain=5.0) >> OrientationTask(hand.rotation, gain=5.0)
    record = simulate(Controller(robot, stack >> PostureTask(q, gain=1.0), dt=5e-3), q, duration=5.0)
    print(f"{name:6} {off(record, 'position', since=3.0):.3f} mm off in the last 2 s")
