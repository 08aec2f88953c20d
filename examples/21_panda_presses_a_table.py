"""A Panda comes down on a table, presses it with 20 N, and keeps its elbow up meanwhile: in MuJoCo."""

import sys

import numpy as np
from _standing import Scales, moved, passed, stops

from tasks import (
    AtLeast,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    Ground,
    JointLimits,
    JointTorqueLimit,
    OrientationTask,
    PositionTask,
    PostureTask,
    Switch,
    load_robot,
    simulate,
)

SECONDS, LOWEST = float(sys.argv[2]) if sys.argv[2:] else 8.0, 0.6  # [s], [m]
robot = load_robot("panda", lock=["panda_finger_joint1"], acceleration_limit=50.0)  # [rad/s^2]
q, tip = robot.home, "panda_hand_tcp"
home = robot.at(q, np.zeros(robot.nv))
here = home.frame(tip).position
table = here - [0.0, 0.0, 0.25]

hand = Contact(tip, friction=0.5, name="hand")
down = PositionTask(stops(here, (2.0, table)), frame=tip, gain=15.0, name="tip")
press = ForceTask(stops([0.0], (2.5, None), (1.0, [20.0])), contact=hand, name="press")
lowest = AtLeast(PositionTask([LOWEST], frame="panda_link4", mask="z", gain=10.0, name="elbow"))
limits = Dynamics() + hand >> JointTorqueLimit() + JointLimits()
pointing = OrientationTask(home.frame(tip).rotation, frame=tip, gain=10.0)
# Turns the elbow out and down.
sagging = PostureTask(np.add(q, [1.2, 0.0, -1.2, 0.0, 0.0, 0.0, 0.0]), gain=4.0, weight=0.5)
rest = pointing + sagging + ForceTask(weight=1e-3)
controller = Controller(robot, limits >> down + press >> lowest >> rest, order="torque", dt=2e-3)

plant = Scales(robot, contacts=[hand], ground=Ground(height=table[2]))
switches = [Switch(0.0, hand, on=False), Switch(2.1, hand, on=True, duration=0.1)]  # it begins above the table
record = simulate(controller, q, duration=SECONDS, plant=plant, changes=switches)

pressed = np.array([forces["hand"][0, 2] for forces in plant.read])  # [N]
height = np.array([robot.at(*state).frame("panda_link4").position[2] for state in zip(record.q, record.v, strict=True)])
print(f"{record}\nin the last 2 s it presses with {pressed[-1000:].min():.2f} to {pressed[-1000:].max():.2f} N")
print(f"elbow from {height[0]:.4f} m to {height[-1]:.4f} m, at least {height.min():.4f} m of {LOWEST} m")
slip = np.linalg.norm(moved(record, hand), axis=1).max()
print(f"the tip slips by at most {1e3 * slip:.2f} mm; no torque passed by more than {passed(record, [hand]):.0e} N m")

if sys.argv[1:]:  # a folder, for the picture
    from _contact_pictures import pressing

    pressing(sys.argv[1], record, pressed, height, table, LOWEST)
