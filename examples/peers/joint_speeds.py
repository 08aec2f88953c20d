"""An arm follows joint speeds that would take it out of its range, and stops in time.

Pink: ``arm_z1_joint_velocity_tracking.py``. The limits are the level above, and joints brake towards them by the
acceleration that is given; in Pink a step may go half of the way to the end of a range.
"""

import numpy as np
from _common import Swing

from tasks import Controller, JointLimits, JointVelocityTask, load_robot, simulate

robot = load_robot("z1", lock=["jointGripper"], acceleration_limit=20.0)
speeds = Swing(np.zeros(robot.nv), 2.0, 1.0)
controller = Controller(robot, JointLimits() >> JointVelocityTask(speeds), dt=5e-3)
record = simulate(controller, robot.home, duration=10.0)

low, high = robot.position_limit
print(f"beyond a range by at most {max((record.q - high).max(), (low - record.q).max()):.1e} rad")
followed = [np.abs(v - speeds(t)[0]).max() < 1e-6 for t, v in zip(record.t[:-1], record.v[1:], strict=True)]
print(f"all speeds as wanted in {np.mean(followed):.0%} of the ticks")
print(controller(record.q[200], record.v[200], t=1.0).solution.explain())
