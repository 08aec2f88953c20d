"""Pendulums from URDF text: one that is stuck at the end of its range, and a double one that follows a target.

Pink: ``one_dof_configuration_limit.py``, ``double_pendulum.py``, ``load_custom_urdf.py``. What a loop of ticks cannot
see, the way around by the other side, ``solve_ik`` finds.
"""

import numpy as np
import pinocchio as pin
from _common import Swing

from tasks import Controller, JointLimits, PinocchioRobot, PositionTask, PostureTask, simulate, solve_ik


def pendulum(*lengths: float, low: float = 0.0) -> PinocchioRobot:
    """Links one above the other, which turn about x from `low` to a whole turn [rad]."""
    text, parent, height = '<link name="base"/>', "base", 0.0
    for i, length in enumerate((*lengths, 0.0)):
        kind, link = "revolute" if length else "fixed", f"link{i}"
        text += (
            f'<link name="{link}"/><joint name="joint{i}" type="{kind}"><parent link="{parent}"/><child link="{link}"/>'
        )
        text += f'<origin xyz="0 0 {height}"/><axis xyz="1 0 0"/>'
        text += f'<limit lower="{low}" upper="6.28" velocity="1" effort="0"/></joint>'
        parent, height = link, length
    return PinocchioRobot(pin.buildModelFromXML(f'<robot name="pendulum">{text}</robot>'), tip=parent)


robot = pendulum(0.25)
tip = PositionTask(robot.at([5.5]).frame().position, gain=5.0, name="tip")
controller = Controller(robot, JointLimits() >> tip, dt=0.01)
record = simulate(controller, [0.5], duration=3.0)
print(f"asked for 5.5 rad from 0.5 rad: stuck at {record.q[-1][0]:.3f} rad")
print(controller(record.q[-1]).solution.explain())
print(f"solve_ik: {solve_ik(robot, JointLimits() >> tip, [0.5]).q[0]:.3f} rad")

robot = pendulum(0.1, 0.2, low=-6.28)
q = np.array([0.3, 1.0])
swing = PositionTask(Swing([0.0, -0.1, 0.2], [0.0, 0.05, 0.0], 1.0), mask="yz", gain=5.0, name="swing")
record = simulate(Controller(robot, JointLimits() >> swing >> PostureTask(q, gain=1.0), dt=0.01), q, duration=6.0)
print(f"double pendulum: {np.abs(record.errors['swing'][300:]).max() * 1e3:.3f} mm off in the last 3 s")
