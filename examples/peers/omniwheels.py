"""A base on three omniwheels goes between two poses, 0.2 m and half a turn apart.

Pink: ``mobile_omni_wheeled_robot.py``, whose wheels do not turn; its own error is a screw, here the way of the base is
straight while it turns. With ``OmniwheelTask`` the wheels turn as the base moves, and their speed limits hold it back.
"""

import numpy as np
import pinocchio as pin

from tasks import Controller, JointLimits, OmniwheelTask, PinocchioRobot, PoseTask, simulate

RADIUS = 0.02  # of a wheel [m]
wheel = """<link name="wheel{i}"/><joint name="axle{i}" type="continuous"><parent link="base"/><child link="wheel{i}"/>
<origin xyz="{x} {y} 0" rpy="0 0 {turn}"/><axis xyz="1 0 0"/><limit velocity="20" effort="1"/></joint>"""
turns = [i * 2.0 * np.pi / 3.0 for i in range(3)]
wheels = "".join(
    wheel.format(i=i, x=0.055 * np.cos(turn), y=0.055 * np.sin(turn), turn=turn) for i, turn in enumerate(turns)
)
model = pin.buildModelFromXML(f'<robot name="omni"><link name="base"/>{wheels}</robot>', pin.JointModelPlanar())
robot = PinocchioRobot(model, tip="base")

rolling = OmniwheelTask(RADIUS, axle=[1.0, 0.0, 0.0], frame="wheel0", floor=-RADIUS, gain=5.0, name="wheel0")
for i in (1, 2):
    rolling = rolling + OmniwheelTask(RADIUS, axle=[1.0, 0.0, 0.0], frame=f"wheel{i}", floor=-RADIUS, gain=5.0)
base = PoseTask(np.zeros(3), np.eye(3), gain=5.0, name="base")
controller = Controller(robot, JointLimits() >> rolling >> base, dt=0.01)

q = robot.home
for k in range(4):
    far = k % 2 == 0
    base.target = pin.SE3(pin.utils.rpyToMatrix(0.0, 0.0, -np.pi * far), np.array([-0.2 * far, 0.0, 0.0]))
    record = simulate(controller, q, duration=2.0)
    q = record.q[-1]
    speed, slip = np.abs(record.v[:, 3:]).max(), np.abs(record.errors["wheel0"]).max()
    print(f"{'there' if far else 'back'}: off by {np.linalg.norm(record.errors['base'][-1]):.1e}", end=", ")
    print(f"wheels at most at {speed:.3f} rad/s")
