"""A configuration of a UR10 for the pose of a random other one.

Pink: ``inverse_kinematics_ur10.py``, ``inverse_kinematics_piper_viz.py``: a loop of ticks until the error is small,
which need not end. ``solve_ik`` takes Newton steps, keeps to the ranges, begins anew where it is stuck, and says why
where there is no solution.
"""

import numpy as np

from tasks import PoseTask, load_robot, solve_ik

robot = load_robot("ur10")
rng = np.random.default_rng(0)
for _ in range(3):
    goal = PoseTask.hold(robot.at(robot.random(rng)), gain=1.0)
    result = solve_ik(robot, goal, robot.neutral, tolerance=1e-8)
    print(f"{result.iterations} hierarchies, {result.restarts} restarts: {result}")
away = solve_ik(robot, PoseTask([2.0, 0.0, 0.0], np.eye(3), gain=1.0), robot.neutral, restarts=False)
print(away)
