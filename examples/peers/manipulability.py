"""Arms bend to where their hands move well: a planar arm of two links, and a Panda with and without the criterion.

Pink: ``planar_2dof_manipulability.py``, ``arm_panda_manipulability_comparison.py``. There the criterion has a rate and
a damping and competes with the hand; here it is a level below the hand, and moves it by nothing.
"""

import numpy as np
from _common import Swing, off

from tasks import (
    Controller,
    JointLimits,
    JointVelocityLimit,
    ManipulabilityTask,
    PlanarArm,
    PoseTask,
    PositionTask,
    PostureTask,
    Record,
    load_robot,
    manipulability,
    simulate,
)

arm = PlanarArm([0.2, 0.2])
moves = ManipulabilityTask(PositionTask([0.2, 0.2], gain=1.0), gain=50.0)
record = simulate(Controller(arm, JointVelocityLimit(2.0) >> moves, dt=0.01), np.ones(2), duration=3.0)
print(f"two links: elbow at {np.degrees(record.q[-1][1]):.1f} deg")

panda = load_robot("panda", lock=["panda_finger_joint1"])
here = panda.at(panda.home).frame()
hand = PoseTask(Swing([0.4, 0.0, 0.4], [0.0, 0.3, 0.2], 1.0), here.rotation, gain=5.0, name="hand")


def mean(record: Record) -> float:
    frames = (panda.at(q).frame() for q in record.q[300::10])
    return float(np.mean([manipulability(np.vstack([frame.linear, frame.angular])) for frame in frames]))


lowest = {"posture": PostureTask(panda.home, gain=1.0), "manipulability": ManipulabilityTask(hand, gain=100.0)}
for name, last in lowest.items():
    record = simulate(Controller(panda, JointLimits() >> hand >> last, dt=0.01), panda.home, duration=7.0)
    print(f"Panda, {name} below: {mean(record):.4f} in the mean, hand {off(record, 'hand', since=3.0):.3f} mm off")
