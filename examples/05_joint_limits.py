"""Joint limits of all three kinds; a start outside its range, and a target which the ranges put out of reach."""

import sys

import numpy as np

from tasks import (
    Controller,
    JointAccelerationLimit,
    JointPositionLimit,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    simulate,
)

LOWEST, HIGHEST = np.radians([-30.0, -120.0, -45.0]), np.radians([100.0, 0.0, 45.0])
arm = PlanarArm(
    [0.7, 0.7, 0.3],
    position_limit=(LOWEST, HIGHEST),  # [rad]
    velocity_limit=1.5,  # [rad/s]
    acceleration_limit=10.0,  # [rad/s^2]
)
limits = JointPositionLimit() + JointVelocityLimit() + JointAccelerationLimit()  # the arm's own
stack = limits >> PositionTask([-0.6, 1.5], gain=4.0) >> OrientationTask(np.pi, gain=4.0)

start = np.radians([60.0, -90.0, -52.0])  # joint 3 is 7 degrees beyond its range
for order in "acceleration", "velocity":
    record = simulate(Controller(arm, stack, order=order, dt=0.01), start, duration=4.0, certify=1)
    print(f"{order} order: {record}")

    outside = np.maximum(record.q - HIGHEST, LOWEST - record.q)  # [rad], negative inside
    back = int(np.argmax(np.all(outside <= 1e-9, axis=1)))
    print(
        f"  joint 3 starts {np.degrees(outside[0, 2]):.1f} deg outside; all are inside from t = {record.t[back]:.2f} s"
    )
    largest = np.degrees(np.max(np.maximum(outside[back:], 0.0)))
    print(f"  afterwards a joint is at most {largest + 0.0:.6f} deg outside")
    print(f"  largest speed {np.abs(record.v).max():.4f} rad/s, acceleration {np.abs(record.a).max():.4f} rad/s^2")
    reached = [joint for joint in range(3) if abs(outside[-1, joint]) < 1e-6]
    tip = np.linalg.norm(record.errors["position"][-1])
    print(f"  at the end joints {[j + 1 for j in reached]} rest on a limit, and the tip is {tip:.3f} m from its target")

if sys.argv[1:]:  # a folder, for the picture of the last run
    from _pictures import planar

    planar(sys.argv[1], "joint_limits.png", record, times=(0.0, 0.5, 1.0, 4.0))
