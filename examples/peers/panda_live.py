"""A Panda in the browser: drag the target of its hand, move the sliders of its gains, change the order of its tasks.

Pink: ``arm_panda.py``, whose sliders are costs; mink: ``arm_iiwa.py``. Here costs are an order, which is changed while
the arm moves, and the page tells what each level lacks and why. ``python panda_live.py --live`` opens it (extra
``live``); without, the same session is led by this program.
"""

import sys

import numpy as np

from tasks import Controller, JointLimits, OrientationTask, PositionTask, PostureTask, live, load_robot
from tasks.view.session import Session

robot = load_robot("panda", lock=["panda_finger_joint1"])
hand = robot.at(robot.home).frame()
position, rotation = PositionTask(hand.position, gain=3.0), OrientationTask(hand.rotation, gain=3.0)
stack = JointLimits() >> position >> rotation >> PostureTask(robot.home, gain=1.0)
controller = Controller(robot, stack, dt=5e-3)

if "--live" in sys.argv:
    live(controller)
    sys.exit()

session = Session(controller)
for target, gain in ([0.5, 0.3, 0.4], 3.0), ([0.5, -0.3, 0.4], 6.0), ([0.3, 0.0, 0.6], 3.0):
    session.targets[0].move(p=target)
    session.set_gain(position, gain)
    for _ in range(30):
        session.advance(0.1)
    away = np.linalg.norm(robot.at(session.q).frame().position - target)
    print(f"target {target}, gain {gain:g} 1/s: {away * 1e3:.1f} mm off")
session.move_level(2, -1)
print("order now:", ", ".join(session.priorities.names))
