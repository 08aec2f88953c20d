"""A robot on a floating base is sent far away, and its base keeps to its speed limits.

Pink: ``floating_base_velocity_limit.py``; mink's ``FreeJointVelocityLimit``. A limit of the speed of any frame will do.
"""

import numpy as np

from tasks import Controller, FrameVelocityLimit, PoseTask, load_robot, simulate

robot = load_robot("go2", tip="base")
slow = FrameVelocityLimit([0.3, 0.3, 0.2, 0.8, 0.8, 0.8], mask="x y z rx ry rz", reference="local", name="base speed")
far = robot.at(robot.home).frame().position + np.array([2.0, 0.0, 0.0])
away = PoseTask(far, np.eye(3), gain=10.0, name="base")
record = simulate(Controller(robot, slow >> away, dt=0.1), robot.home, duration=8.0)
fastest = np.abs(record.v[:, :6]).max(axis=0)
print(f"fastest {fastest.round(6)}, at the end {np.linalg.norm(record.errors['base'][-1]):.1e} m off")
