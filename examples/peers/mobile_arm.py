"""An arm on a base that drives: the base helps it to reach, or is told to stand.

Pink: ``mobile_stretch.py``, ``stretch_relative_target.py``, ``stretch_world_target.py``; mink: ``mobile_stretch.py``,
``mobile_tidybot.py``, ``mobile_kinova.py``, where a cost of 100 makes the base stand. ``Freeze`` does so exactly.
"""

import numpy as np

from tasks import Controller, Freeze, JointLimits, PositionTask, PostureTask, load_robot, simulate

robot = load_robot("tiago", base="planar", velocity_limit=1.0)
start = robot.at(robot.home)
goal = start.frame().position + np.array([-0.1, 0.1, -0.1])
reach = PositionTask(goal, gain=2.0, name="hand")
posture = PostureTask(robot.home, gain=1.0)
still = Freeze([0, 1, 2], name="base stands")
stacks = {"drives": JointLimits() >> reach >> posture, "stands": JointLimits() >> still >> reach >> posture}
for name, stack in stacks.items():
    record = simulate(Controller(robot, stack, dt=0.01), robot.home, duration=6.0)
    way = np.linalg.norm(robot.at(record.q[-1]).frame("base_footprint").position)
    print(f"base {name}: it goes {way:.2f} m, hand {np.linalg.norm(record.errors['hand'][-1]) * 1e3:.2f} mm off")
