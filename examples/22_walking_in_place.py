"""A humanoid walks in place: a foot is lifted or put down every 0.4 s, in MuJoCo, by joint torques alone."""

import sys

import numpy as np
from _pendulum import Steps
from _standing import tell

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
    load_robot,
    simulate,
)

SECONDS, PHASE, RAMP = float(sys.argv[2]) if sys.argv[2:] else 20.0, 0.4, 0.05  # [s]
robot = load_robot("g1", acceleration_limit=200.0)  # [rad/s^2]
q = robot.home
home = robot.at(q, np.zeros(robot.nv))
com, frames = home.center_of_mass.position, {side: f"{side}_ankle_roll_link" for side in ("right", "left")}
places = {side: home.frame(frame) for side, frame in frames.items()}
floor = np.array([0.0, 0.0, places["left"].position[2] - 0.03])

sole = [(x, y, -0.03) for x in (-0.05, 0.12) for y in (-0.03, 0.03)]
right, left = (Contact(frame, points=sole, friction=0.6, name=side) for side, frame in frames.items())
steps = Steps(
    {side: place.position[1] for side, place in places.items()}, com, floor[2], PHASE, 2.0, SECONDS - 2.0, 0.03
)
swings = [
    PoseTask((steps.foot(side, place.position, 2 * RAMP), place.rotation), frame=frames[side], gain=20.0, name=side)
    for side, place in places.items()
]
upright = OrientationTask(home.frame("pelvis").rotation, frame="pelvis", gain=8.0)
limits = Dynamics() + left + right >> JointTorqueLimit() + JointLimits()
rest = upright >> PostureTask(q, gain=4.0) + ForceTask(weight=1e-2)
walk = CenterOfMassTask(steps.center_of_mass, gain=10.0) + swings[0] + swings[1]
controller = Controller(robot, limits >> walk >> rest, order="torque", dt=2e-3)

plant = MujocoPlant(robot, contacts=(left, right))
record = simulate(controller, q, duration=SECONDS, plant=plant, changes=steps.switches(RAMP))

tell(record, (left, right), plant, still=SECONDS - 0.5)
print(f"{len(steps.switches(RAMP))} switches of contacts; the mass sways by {1e3 * np.ptp(steps.c):.0f} mm")

if sys.argv[1:]:  # a folder, for the picture
    from _contact_pictures import feet

    feet(sys.argv[1], "walking.png", record, (left, right), times=(0.0, 4.65, 5.45))
