"""A quadruped squats, lifts a leg, and is pushed aside with 60 N for 0.2 s, by joint torques alone, in MuJoCo."""

import sys

import numpy as np
from _standing import stops, tell

from tasks import (
    CenterOfMassTask,
    Contact,
    Controller,
    Dynamics,
    ForceTask,
    JointLimits,
    JointTorqueLimit,
    MujocoPlant,
    OrientationTask,
    PositionTask,
    PostureTask,
    Switch,
    load_robot,
    simulate,
)

SECONDS = float(sys.argv[2]) if sys.argv[2:] else 18.0
PUSH = min(6.0, SECONDS - 1.5)  # [s]: when it is pushed
robot = load_robot("go2", acceleration_limit=500.0)  # [rad/s^2]
q = robot.home
home = robot.at(q, np.zeros(robot.nv))
com, foot = home.center_of_mass.position, home.frame("FR_foot").position
low, aside = np.add(com, [0.0, 0.0, -0.06]), np.add(com, [-0.03, 0.02, 0.0])
raised = np.add(foot, [0.0, 0.0, 0.06])

feet = tuple(Contact(f"{leg}_foot", friction=0.6, name=leg) for leg in ("FL", "FR", "RL", "RR"))
squat = stops(com, (0.3, None), (0.7, low), (0.7, com), (0.1, None), (0.6, aside), (2.3, None), (0.6, com))
lift = PositionTask(stops(foot, (2.9, None), (0.4, raised), (0.4, None), (0.4, foot)), frame="FR_foot", gain=20.0)
upright = OrientationTask(home.frame("base").rotation, frame="base", gain=8.0)
limits = Dynamics() + feet[0] + feet[1] + feet[2] + feet[3] >> JointTorqueLimit() + JointLimits()
rest = upright >> PostureTask(q, gain=4.0) + ForceTask(weight=1e-2)
stack = limits >> CenterOfMassTask(squat, gain=6.0) + lift >> rest
controller = Controller(robot, stack, order="torque", dt=2e-3)

plant = MujocoPlant(robot, contacts=feet)
plant.push("base", [0.0, 60.0, 0.0], 0.2, start=PUSH)
switches = [Switch(2.5, "FR", on=False, duration=0.15), Switch(4.2, "FR", on=True, duration=0.15)]
record = simulate(controller, q, duration=SECONDS, plant=plant, changes=switches)

tell(record, feet, plant, still=min(8.0, SECONDS - 0.5))
off = 1e3 * np.linalg.norm(record.errors["center of mass"], axis=1)
before, after = record.t < PUSH, record.t >= PUSH
print(f"center of mass off by at most {off[before].max():.2f} mm before the push, {off[after].max():.1f} mm after it")

if sys.argv[1:]:  # a folder, for the picture
    from _contact_pictures import feet as draw

    draw(sys.argv[1], "quadruped.png", record, feet, times=(0.0, 1.0, 3.5), mark=(PUSH, PUSH + 0.2))
