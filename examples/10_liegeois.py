"""A Panda's hand goes round a triangle, round after round: its joints drift to a limit, or a level below keeps them."""

import sys

import numpy as np

from tasks import Chain, Controller, JointCentringTask, JointLimits, Line, PositionTask, load_robot, quintic, simulate

ROUNDS, SIDE = 6, 1.5  # how many, and how long one side takes [s]
robot = load_robot("panda", lock=["panda_finger_joint1"])
low, high = robot.position_limit
corners = [robot.at(robot.home, np.zeros(robot.nv)).frame().position, [0.6, 0.3, 0.1], [0.6, -0.3, 0.6]]  # [m]
sides = [Line(corners[i], corners[(i + 1) % 3], duration=SIDE, timing=quintic) for i in range(3)]
hand = PositionTask(Chain(ROUNDS * sides), gain=10.0)

records = {}
for name, stack in (
    ("least speed", JointLimits() >> hand),
    ("centred", JointLimits() >> hand >> JointCentringTask(gain=10.0)),
):
    controller = Controller(robot, stack, dt=0.01, damping=None)  # of which joints drift, least speed alone decides
    record = records[name] = simulate(controller, robot.home, duration=3 * SIDE * ROUNDS)
    relative = (2.0 * record.q - high - low) / (high - low)  # -1 .. 1 is the range of a joint
    error = 1e3 * np.linalg.norm(record.errors["position"], axis=1)
    print(f"{name}: {record}")
    print("  H after each round:", np.mean(relative[:: round(300 * SIDE)] ** 2, axis=1).round(3))
    print(f"  a joint at {100 * np.abs(relative).max():.0f} % of its half range, the hand {error.max():.1f} mm off")

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import liegeois

    liegeois(sys.argv[1], robot, records)
