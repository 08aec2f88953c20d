"""Welding a socket to a plate: the seam first, the torch last, and what the other order does to the seam."""

import sys

import numpy as np

from tasks import (
    AxisTask,
    Circle,
    Controller,
    Damping,
    JointLimits,
    PositionTask,
    PostureTask,
    load_robot,
    quintic,
    simulate,
    solve_ik,
)

CENTRE, RADIUS, HEIGHT = [0.55, 0.0], 0.08, 0.3  # of the seam, a circle [m]
TILT, LAP = np.radians(30.0), 20.0  # of the torch towards the plate [rad]; of one way round [s]
robot = load_robot("panda", lock=["panda_finger_joint1"])


def at_height(path, z):
    """A path in the plane as one in space: the functions of time that tasks take for targets."""
    return lambda t: tuple(np.append(part, height) for part, height in zip(path(t), (z, 0.0, 0.0), strict=True))


# The torch points at the axis of the socket, and TILT down: opposite to the radius on which the tip is.
ring = Circle(CENTRE, RADIUS, LAP, start=np.pi, turn=2 * np.pi, timing=quintic)
inwards = Circle([0.0, 0.0], np.cos(TILT), LAP, start=0.0, turn=2 * np.pi, timing=quintic)
seam = PositionTask(at_height(ring, HEIGHT), gain=10.0, name="seam")
torch = AxisTask(at_height(inwards, -np.sin(TILT)), gain=10.0, name="torch")

start = solve_ik(robot, seam >> torch >> PostureTask(robot.home, gain=1.0)).q
orders = {"seam first": seam >> torch + Damping(0.1), "torch first": torch >> seam + Damping(0.1)}
records = {}
for name, order in orders.items():
    controller = Controller(robot, JointLimits() >> order, dt=0.01)
    record = records[name] = simulate(controller, start, duration=LAP, certify=50)
    off = 1e3 * np.linalg.norm(record.errors["seam"], axis=1)
    tilted = np.degrees(np.linalg.norm(record.errors["torch"], axis=1))
    print(f"{name:12} tip off by at most {off.max():5.2f} mm, torch by {tilted.max():5.2f} deg", end="; ")
    print(
        f"tip within 1 mm for {np.mean(off < 1.0):4.0%}, torch within 5 deg for {np.mean(tilted < 5.0):4.0%}", end="; "
    )
    print(f"{record.certified} of {record.checked} certified")

k = int(np.argmax(np.linalg.norm(records["seam first"].errors["torch"], axis=1)))
t, q, v = (getattr(records["seam first"], name)[k] for name in ("t", "q", "v"))
print(f"\nat t = {t:.1f} s the torch is worst. What holds it back?")
print(Controller(robot, JointLimits() >> orders["seam first"], dt=0.01)(q, v, t).solution.explain())

if sys.argv[1:]:  # a folder, for the picture
    from _application_pictures import welding

    welding(sys.argv[1], robot, records, TILT)
