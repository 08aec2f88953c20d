"""An arm is asked to go through a wall, and goes along it.

Pink: ``barriers/arm_ur5.py``, whose ``PositionBarrier`` has two sides, gain 100, and a safe displacement beside it.
Here the wall is a level: nothing below moves it, and no cost keeps steps short.
"""

import numpy as np
from _common import Swing, off

from tasks import BoxLimit, Controller, JointLimits, OrientationTask, PositionTask, PostureTask, load_robot, simulate

robot = load_robot("ur5")
q = np.array([1.27, -0.88, 1.89, 1.74, -0.25, -0.75])
hand = robot.at(q).frame()
wall = BoxLimit([-np.inf, -0.4, -np.inf], [np.inf, 0.6, np.inf], gain=100.0, name="wall")
target = Swing([hand.position[0], 0.0, 0.5], [0.0, 0.65, 0.0], 0.5)
hold = OrientationTask(hand.rotation, gain=5.0) >> PostureTask(q, gain=1.0)
controller = Controller(robot, JointLimits() >> wall >> PositionTask(target, gain=5.0) >> hold, dt=5e-3)
record = simulate(controller, q, duration=12.7)

y = np.array([robot.at(q).frame().position[1] for q in record.q])
print(f"asked to go from -0.65 to 0.65 m, gone from {y.min():.4f} to {y.max():.4f} m")
print(f"between the sides again {off(record, 'position', since=12.5):.3f} mm off")
