"""A humanoid reaches for a thing that is too far: it leans as far as its feet bear it, and says what stopped it."""

import sys

import numpy as np
from _standing import stops, tell

from tasks import (
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
    SupportLimit,
    load_robot,
    simulate,
)

SECONDS, MARGIN = float(sys.argv[2]) if sys.argv[2:] else 14.0, 0.02  # [s], [m]
robot = load_robot("g1", acceleration_limit=200.0)  # [rad/s^2]
q, hand = robot.home, "right_rubber_hand"
home = robot.at(q, np.zeros(robot.nv))

sole = [(x, y, -0.03) for x in (-0.05, 0.12) for y in (-0.03, 0.03)]
feet = tuple(Contact(f"{side}_ankle_roll_link", points=sole, friction=0.6, name=side) for side in ("left", "right"))
thing = np.array([0.75, -0.15, 0.55])
reach = PositionTask(stops(home.frame(hand).position, (3.0, thing)), frame=hand, gain=3.0, name="hand")
# Beside the reach, as joints would turn ever faster for what cannot be reached.
calm = PostureTask(q, gain=4.0, weight=0.1, name="calm")
limits = Dynamics() + feet[0] + feet[1] >> JointTorqueLimit() + JointLimits()
upright = OrientationTask(home.frame("pelvis").rotation, frame="pelvis", gain=4.0)
rest = upright >> PostureTask(q, gain=4.0) + ForceTask(weight=1e-2)
controller = Controller(robot, limits >> SupportLimit(MARGIN) >> reach + calm >> rest, order="torque", dt=2e-3)

plant = MujocoPlant(robot, contacts=feet)
record = simulate(controller, q, duration=SECONDS, plant=plant)

tell(record, feet, plant, still=min(4.0, SECONDS - 1.0))
off = 1e3 * np.linalg.norm(record.errors["hand"], axis=1)
leant = robot.at(record.q[-1], record.v[-1]).center_of_mass.position - home.center_of_mass.position
print(f"the hand is {off[-1]:.0f} mm short, the mass {1e3 * leant[0]:.0f} mm farther forward")
print(controller(record.q[-1], record.v[-1], SECONDS).solution.explain())

if sys.argv[1:]:  # a folder, for the picture
    from _contact_pictures import leaning

    leaning(sys.argv[1], record, feet, hand, thing, MARGIN)
