"""An arm follows a target: first as it will, then with smooth speeds, by a limit of acceleration and a lower gain.

Pink: ``arm_ur3_velocity_smoothing.py``, with a damping task in place of the posture. Here the same parts are live: the
gain and the limit are set while the arm moves.
"""

import numpy as np
from _common import Swing, off

from tasks import Controller, JointLimits, OrientationTask, PositionTask, PostureTask, load_robot, simulate

robot = load_robot("ur3", acceleration_limit=1e3)
q = robot.configuration({"shoulder_pan_joint": 1.0, "shoulder_lift_joint": -1.0, "elbow_joint": 1.0})
hand = robot.at(q).frame()
position = PositionTask(Swing([hand.position[0], 0.3, 0.2], [0.0, 0.1, 0.0], 2.0), gain=100.0)
rotation = OrientationTask(hand.rotation, gain=100.0)
controller = Controller(robot, JointLimits() >> position >> rotation >> PostureTask(q, gain=1.0), dt=5e-3)
for gain, acceleration in (100.0, 1e3), (10.0, 20.0):
    position.gain, rotation.gain, robot.acceleration_limit = gain, gain, acceleration
    record = simulate(controller, q, duration=5.0)
    jump = np.abs(np.diff(record.v, axis=0)).max() / 5e-3
    print(f"gain {gain:g} 1/s: accelerations up to {jump:.1f} rad/s^2, {off(record, 'position', since=2.0):.2f} mm off")
