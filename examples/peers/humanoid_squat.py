"""A humanoid squats: its centre of mass goes up and down above feet that stand.

Pink: ``humanoid_g1_com.py``, ``humanoid_jvrc_com.py``; mink: ``humanoid_g1.py``, ``humanoid_h1.py``. Feet, centre of
mass, pelvis, hands and posture are levels in this order; there the ratio is chosen by costs from 0.1 to 200.
"""

import numpy as np
from _common import Swing, off

from tasks import (
    CenterOfMassTask,
    Controller,
    JointLimits,
    OrientationTask,
    PoseTask,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)

robot = load_robot("g1")
start = robot.at(robot.home)
mass = start.center_of_mass.position
left = PoseTask.hold(start, frame="left_ankle_roll_link", gain=100.0, name="left")
right = PoseTask.hold(start, frame="right_ankle_roll_link", gain=100.0, name="right")
squat = CenterOfMassTask(Swing(mass - [0.0, 0.0, 0.08], [0.0, 0.0, 0.05], np.pi, np.pi / 2), gain=10.0)
hands = [
    PositionTask(start.frame(f).position - np.array([0.1, 0.0, 0.1]), frame=f, gain=3.0, name=f)
    for f in ("left_wrist_yaw_link", "right_wrist_yaw_link")
]
lower = OrientationTask(np.eye(3), frame="pelvis", gain=5.0) >> hands[0] + hands[1] >> PostureTask(robot.home, gain=1.0)
record = simulate(Controller(robot, JointLimits() >> left + right >> squat >> lower, dt=5e-3), robot.home, duration=6.0)

print(f"centre of mass {off(record, 'center of mass', since=1.0):.3f} mm off", end=", ")
print(f"feet slip by {off(record, 'left', 'right'):.0e} mm")
print("at the end " + ", ".join(f"{name} {np.linalg.norm(e[-1]):.2g}" for name, e in record.errors.items()))
