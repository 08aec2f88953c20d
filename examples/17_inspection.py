"""A camera goes round a valve and looks at it, among pipes: first the distance, then the sight, then the place."""

import sys

import numpy as np

from tasks import (
    Capsule,
    Circle,
    Controller,
    Damping,
    DistanceLimit,
    JointLimits,
    JointPositionLimit,
    JointVelocityLimit,
    LinkCapsule,
    LookAtTask,
    PositionTask,
    PostureTask,
    load_robot,
    quintic,
    simulate,
    solve_ik,
)

VALVE, RADIUS, ABOVE, SECONDS = [0.55, 0.0, 0.3], 0.2, 0.15, 10.0  # [m], [s]: the camera goes round at this distance
MARGIN, THICK = 0.02, 0.03  # [m]: distance to keep, radius of the pipes
robot = load_robot("panda", lock=["panda_finger_joint1"])
pipes = [Capsule([x, y, 0.0], [x, y, 1.1], THICK) for x, y in ((0.16, -0.36), (0.12, 0.27))]
links = [
    LinkCapsule("panda_link3", "panda_link4", 0.07),
    LinkCapsule("panda_link5", [0.0, 0.0, -0.26], 0.06, name="forearm"),
    LinkCapsule("panda_link7", "panda_hand", 0.05),
    LinkCapsule("panda_hand", "panda_hand_tcp", 0.04),
]
arc = Circle(VALVE[:2], RADIUS, SECONDS, start=0.6 * np.pi, turn=0.8 * np.pi, timing=quintic)


def round_the_valve(t):  # the arc at the height of the camera, its velocity and acceleration
    return tuple(np.append(part, z) for part, z in zip(arc(t), (VALVE[2] + ABOVE, 0.0, 0.0), strict=True))


limits = JointLimits(JointVelocityLimit(0.5), JointPositionLimit())
clear = DistanceLimit(links, pipes, margin=MARGIN, gain=10.0)
sight, camera = LookAtTask(VALVE, gain=5.0, name="sight"), PositionTask(round_the_valve, gain=5.0, name="camera")
tasks = sight >> camera + Damping(0.03)
start = solve_ik(robot, limits >> sight >> camera >> PostureTask(robot.home, gain=1.0)).q
records, apart = {}, {}
for name, stack in ("pipes unknown", limits >> tasks), ("pipes known", limits >> clear >> tasks):
    record = records[name] = simulate(Controller(robot, stack, dt=0.01), start, duration=SECONDS, certify=50)
    apart[name] = np.array([clear.distances(robot, robot.at(q, np.zeros(7))).min() for q in record.q])
    off, aside = (np.linalg.norm(record.errors[task], axis=1).max() for task in ("camera", "sight"))
    print(f"{name:13} nearest {1e3 * apart[name].min():6.2f} mm, sight off by {np.degrees(aside):.2f} deg", end=", ")
    print(f"camera by {1e3 * off:5.2f} mm; {record.certified} of {record.checked} certified")

if sys.argv[1:]:  # a folder, for the picture
    from _application_pictures import inspection

    inspection(sys.argv[1], robot, records, apart, pipes, VALVE, MARGIN)
