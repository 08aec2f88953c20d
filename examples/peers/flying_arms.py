"""Two UR3 arms on a body that flies: their hands stay where they are told while the body goes up and down.

Pink: ``flying_dual_arm_ur3.py``; mink: ``flying_dual_arm_ur5e.py``. The model is put together by Pinocchio, as there.
The hands are a level above the body: where both cannot be had, the body gives way.
"""

import numpy as np
import pinocchio as pin
from _common import Swing, off

from tasks import Controller, JointLimits, PinocchioRobot, PoseTask, PostureTask, load_robot, simulate

body = pin.Model()
joint = body.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
body.appendBodyToJoint(joint, pin.Inertia.FromBox(10.0, 0.8, 0.4, 0.2), pin.SE3.Identity())
body.addBodyFrame("base", joint, pin.SE3.Identity(), body.addJointFrame(joint))
for side, x in ("left", 0.3), ("right", -0.3):
    arm = load_robot("ur3").model.copy()
    for frame in arm.frames:
        frame.name = f"{side}_{frame.name}"
    for i, name in enumerate(arm.names):
        arm.names[i] = f"{side}_{name}"
    place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
    body = pin.appendModel(body, arm, body.getFrameId("base"), place)

robot = PinocchioRobot(body, name="flying arms")
bend = {"shoulder_lift_joint": -1.0, "shoulder_pan_joint": 1.0, "elbow_joint": 1.0}
q = robot.configuration({f"{side}_{name}": angle for side in ("left", "right") for name, angle in bend.items()})
start = robot.at(q)


def hand(side: str) -> PoseTask:
    """Swings sideways, and is held as it stands."""
    here = start.frame(frame := f"{side}_tool0")
    swing = Swing([here.position[0], 0.5, 0.2], [0.0, 0.1, 0.0], 2.0)
    return PoseTask(swing, here.rotation, frame=frame, gain=5.0, name=side)


body_goes = PoseTask(Swing(np.zeros(3), [0.0, 0.0, 0.3], 2.0), np.eye(3), frame="base", gain=5.0, name="body")
stack = JointLimits() >> hand("left") + hand("right") >> body_goes >> PostureTask(q, gain=1.0)
# On a body that flies hands are always in reach: there is nothing to damp.
record = simulate(Controller(robot, stack, dt=5e-3), q, duration=6.0)
print(f"in the last 3 s: hands {off(record, 'left', 'right', since=3.0):.3f} mm off", end=", ")
print(f"body {off(record, 'body', since=3.0):.0f} mm")
