"""A humanoid reaches forward and down with both hands, farther than it can: it keeps its feet, and does not fall."""

import sys

import numpy as np

from tasks import (
    CenterOfMassTask,
    Chain,
    Controller,
    Damped,
    JointLimits,
    Line,
    OrientationTask,
    PoseTask,
    PositionTask,
    PostureTask,
    Within,
    load_robot,
    quintic,
    simulate,
)

TICK, MARGIN = 2e-3, 0.04  # [s], [m]
robot = load_robot("g1")
home = robot.at(robot.home, np.zeros(robot.nv))


def foot(side: str) -> PoseTask:
    frame = home.frame(name := f"{side}_ankle_roll_link")
    return PoseTask(frame.position, frame.rotation, frame=name, gain=1.0 / TICK, name=f"{side} foot")


def hand(side: str, y: float) -> PositionTask:
    name = f"{side}_rubber_hand"
    way = home.frame(name).position, [0.7, y, 0.35]
    out, back = (Line(*ends, duration=3.0, timing=quintic) for ends in (way, way[::-1]))
    return PositionTask(Chain([out, back]), frame=name, gain=10.0, name=f"{side} hand")


balance = Within(CenterOfMassTask(home.center_of_mass.position[:2], mask="xy", gain=10.0), MARGIN)
torso = OrientationTask(np.eye(3), frame="torso_link", mask="xy", gain=2.0, name="torso")
# All levels give way calmly where they cannot be met, but for the balance: its bound is a bound.
lower = hand("left", 0.2) + hand("right", -0.2) >> torso >> PostureTask(robot.home, gain=2.0)
controller = Controller(robot, JointLimits() >> foot("left") + foot("right") >> Damped(balance, None) >> lower, dt=TICK)
record = simulate(controller, robot.home, duration=6.0, certify=20)

away = {name: 1e3 * np.linalg.norm(error, axis=1) for name, error in record.errors.items()}  # [mm]
print(f"{record}\nthe feet move by at most {max(away['left foot'].max(), away['right foot'].max()):.4f} mm")
for k in range(0, len(record) + 1, 500):
    forward = 1e3 * (robot.at(record.q[k], record.v[k]).center_of_mass.position - home.center_of_mass.position)[0]
    print(f"  t = {record.t[k]:.0f} s: left hand {away['left hand'][k]:6.2f} mm off, mass {forward:6.2f} mm forward")
solution = controller(record.q[1500], record.v[1500], t=3.0).solution
print(f"at t = 3 s the feet are held to {solution.levels[1].residual_norm:.0e} m/s\n{solution.explain()}")

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import humanoid_reach

    humanoid_reach(sys.argv[1], robot, record, MARGIN)
