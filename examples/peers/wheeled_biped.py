"""A body on two legs with wheels rolls forward, squats, and steps with its wheels to and fro.

Pink: ``upkie_rolling.py``, ``upkie_crouching.py``. Rolling without slip is a level, where there it is ``constraints=``.
"""

import numpy as np
import pinocchio as pin
from _common import Swing, off

from tasks import Controller, JointLimits, PinocchioRobot, PoseTask, PositionTask, PostureTask, RollingTask, simulate

RADIUS, TURN = 0.06, '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="20" effort="1"/>'
text = '<link name="body"/>'
for side, y in ("left", 0.15), ("right", -0.15):
    parent = "body"
    for part, kind, z in ("hip", "revolute", 0.0), ("knee", "revolute", -0.25), ("wheel", "continuous", -0.25):
        text += f'<link name="{side}_{part}"/><joint name="{side} {part}" type="{kind}"><parent link="{parent}"/>'
        text += f'<child link="{side}_{part}"/><origin xyz="0 {y} {z}"/>{TURN}</joint>'
        parent, y = f"{side}_{part}", 0.0
robot = PinocchioRobot(pin.buildModelFromXML(f'<robot name="biped">{text}</robot>', pin.JointModelFreeFlyer()))
bend = {"hip": 0.4, "knee": -0.8}
q = robot.configuration({f"{side} {part}": angle for side in ("left", "right") for part, angle in bend.items()})
q[2] = RADIUS - robot.at(q).frame("left_wheel").position[2]
start = robot.at(q)

roll = [RollingTask(RADIUS, frame=f"{side}_wheel", gain=20.0, name=f"{side} rolls") for side in ("left", "right")]
x, height = start.frame("left_wheel").position[0], q[2]


AHEAD = np.array([0.1, 0.0, 0.0])  # [m/s]


class Along:
    """Another trajectory, carried forward."""

    def __init__(self, swing: Swing) -> None:
        self.swing = swing

    def __call__(self, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        p, v, a = self.swing(t)
        return p + t * AHEAD, v + AHEAD, a


squat = Along(Swing([0.0, 0.0, height - 0.03], [0.0, 0.0, 0.02], 2.0))
body = PoseTask(squat, np.eye(3), frame="body", gain=5.0, name="body")
steps = []
for side, far in ("left", 0.05), ("right", -0.05):
    swing = Along(Swing([x, 0.0, 0.0], [far, 0.0, 0.0], 1.0))
    steps.append(PositionTask(swing, mask="x", frame=f"{side}_wheel", gain=5.0, name=side))
stack = JointLimits() >> roll[0] + roll[1] >> body >> steps[0] + steps[1] >> PostureTask(q, gain=1.0)
record = simulate(Controller(robot, stack, dt=5e-3), q, duration=8.0)
print(f"wheels slip and leave the floor by at most {off(record, 'left rolls', 'right rolls'):.1e} mm", end=", ")
print(f"body {off(record, 'body', since=2.0):.3f}, steps {off(record, 'left', 'right', since=2.0):.3f} mm off")
