"""A humanoid shifts its weight, lifts a foot and puts it down, by joint torques alone, in MuJoCo."""

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
    PoseTask,
    PostureTask,
    Switch,
    load_robot,
    simulate,
)

SECONDS = float(sys.argv[2]) if sys.argv[2:] else 17.0
robot = load_robot("g1", acceleration_limit=200.0)  # [rad/s^2]
q = robot.home
home = robot.at(q, np.zeros(robot.nv))
com, foot = home.center_of_mass.position, home.frame("right_ankle_roll_link")
over = np.array([com[0], home.frame("left_ankle_roll_link").position[1], com[2]])
raised = np.add(foot.position, [0.0, 0.0, 0.06])

sole = [(x, y, -0.03) for x in (-0.05, 0.12) for y in (-0.03, 0.03)]
left, right = (Contact(f"{side}_ankle_roll_link", points=sole, friction=0.6, name=side) for side in ("left", "right"))
weight = CenterOfMassTask(stops(com, (0.5, None), (1.0, over), (3.5, None), (1.0, com)), gain=6.0)
way = stops(foot.position, (2.2, None), (0.8, raised), (0.6, None), (0.8, foot.position))
swing = PoseTask((way, foot.rotation), frame="right_ankle_roll_link", gain=20.0)
upright = OrientationTask(home.frame("pelvis").rotation, frame="pelvis", gain=8.0)
limits = Dynamics() + left + right >> JointTorqueLimit() + JointLimits()
rest = upright >> PostureTask(q, gain=4.0) + ForceTask(weight=1e-2)
controller = Controller(robot, limits >> weight + swing >> rest, order="torque", dt=2e-3)

plant = MujocoPlant(robot, contacts=(left, right))
switches = [Switch(1.6, right, on=False, duration=0.2), Switch(4.6, right, on=True, duration=0.2)]
record = simulate(controller, q, duration=SECONDS, plant=plant, changes=switches)

tell(record, (left, right), plant, still=min(7.0, SECONDS - 1.0))
height = [robot.at(q, v).frame("right_ankle_roll_link").position[2] for q, v in zip(record.q, record.v, strict=True)]
print(f"the foot is lifted by {1e3 * (max(height) - height[0]):.1f} mm")

if sys.argv[1:]:  # a folder, for the picture
    from _contact_pictures import feet

    feet(sys.argv[1], "biped.png", record, (left, right), times=(0.0, 1.6, 3.3))
