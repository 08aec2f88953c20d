"""A Panda with a third of its torques draws a figure eight in MuJoCo; for half the time faster than its motors can."""

import sys

import numpy as np

from tasks import (
    Controller,
    JointLimits,
    JointTorqueLimit,
    MujocoPlant,
    OrientationTask,
    PositionTask,
    PostureTask,
    load_robot,
    simulate,
)

SECONDS = float(sys.argv[2]) if sys.argv[2:] else 60.0
SLOW, FAST, BLEND = 5.0, 2.0, 0.2  # [s]: the periods of the eight, and how soon one follows the other
SIZE, WAVES = np.array([0.0, 0.25, 0.15]), np.array([0, 1, 2])  # [m]; y once a period, z twice
motors = np.array([29.0, 29.0, 29.0, 29.0, 4.0, 4.0, 4.0])  # [N m]; a Panda has 87 and 12
robot = load_robot("panda", lock=["panda_finger_joint1"], torque_limit=motors, acceleration_limit=30.0)
hand = robot.at(robot.home, np.zeros(robot.nv)).frame()


def eight(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration; its rate rises softly at 1 s from rest, and half-way to the faster one."""
    phase = rate = change = 0.0
    for start, more in (1.0, 2 * np.pi / SLOW), (SECONDS / 2, 2 * np.pi * (1 / FAST - 1 / SLOW)):
        share = 1.0 / (1.0 + np.exp((start - t) / BLEND))
        phase += more * BLEND * np.logaddexp(0.0, (t - start) / BLEND)
        rate += more * share
        change += more * share * (1.0 - share) / BLEND
    s, c = SIZE * np.sin(WAVES * phase), SIZE * WAVES * np.cos(WAVES * phase)
    return hand.position + s, c * rate, c * change - WAVES**2 * s * rate**2


# The posture keeps the arm from wandering to where the motors suffice, and the hand from tumbling where they do not.
turn = OrientationTask(hand.rotation, gain=15.0) + PostureTask(robot.home, gain=5.0, weight=0.5)
tasks = PositionTask(eight, gain=15.0) >> turn
controller = Controller(robot, JointTorqueLimit() >> JointLimits() >> tasks, order="torque", dt=2e-3)
record = simulate(controller, robot.home, duration=SECONDS, certify=100, plant=MujocoPlant(robot))

print(record)
at_limit, half = (record.active["torque"] != 0).any(axis=1), len(record) // 2
for name, part in ("slow", slice(0, half)), ("fast", slice(half, None)):
    away = 1e3 * np.linalg.norm(record.errors["position"][part], axis=1).max()
    tilt = np.degrees(np.linalg.norm(record.errors["orientation"][part], axis=1).max())
    print(f"{name}: hand at most {away:.2f} mm off, {tilt:.2f} deg; a motor at its limit {at_limit[part].mean():.1%}")
print(f"no torque exceeds its limit by more than {max((np.abs(record.tau) - motors).max(), 0.0):.0e} N m")
k = int(np.argmax(at_limit))
print(controller(record.q[k], record.v[k], record.t[k]).solution.explain())

if sys.argv[1:]:  # a folder, for the pictures
    from _pictures import torque_panda

    torque_panda(sys.argv[1], robot, record)
