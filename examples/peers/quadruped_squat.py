"""A quadruped moves its trunk sideways and up on four feet that stand, below a ceiling and beside a wall.

Pink: ``barriers/go2_squat.py``; mink: ``quadruped_go1.py``. The feet are a level above the trunk, in place of costs of
200 and 50, and slip by less than 0.1 mm. The barrier is a level too.
"""

import numpy as np
from _common import Swing, off

from tasks import BoxLimit, Controller, JointLimits, OrientationTask, PositionTask, PostureTask, load_robot, simulate

FEET = ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
robot = load_robot("go2")
leg = {"hip": 0.0, "thigh": 0.8, "calf": -1.57}
q = robot.configuration({f"{foot[:2]}_{joint}_joint": angle for foot in FEET for joint, angle in leg.items()})
q[2] = 0.3  # the trunk, above the ground [m]
start = robot.at(q)

stand, *others = (PositionTask(start.frame(f).position, frame=f, gain=100.0, name=f) for f in FEET)
for foot in others:
    stand = stand + foot
free = np.full(3, np.inf)
room = BoxLimit(-free, [np.inf, 0.0, 0.35], frame="base", gain=20.0, name="wall and ceiling")
trunk = PositionTask(Swing([0.0, 0.0, 0.3], [0.0, 0.1, 0.2], np.pi / 2), frame="base", gain=10.0, name="trunk")
lower = trunk >> OrientationTask(np.eye(3), frame="base", gain=10.0) >> PostureTask(q, gain=1.0)
record = simulate(Controller(robot, JointLimits() >> stand >> room >> lower, dt=5e-3), q, duration=8.0)

base = np.array([robot.at(q).frame("base").position for q in record.q])
print(f"the trunk goes from {base[:, 1].min():.3f} to {base[:, 1].max():.4f} m and up to {base[:, 2].max():.4f} m")
print(f"feet slip by at most {off(record, *FEET):.4f} mm")
