"""Least torque at every instant is not least torque: on a long move the arm whips up, and a balance is the remedy."""

import sys

import numpy as np

from tasks import Controller, Line, MinimumMotionTask, MinimumTorqueTask, PlanarArm, PositionTask, quintic, simulate

arm = PlanarArm([1.0, 1.0, 1.0], masses=[10.0, 10.0, 10.0])  # [m], [kg]
start = [2.6, -1.0, -1.4]  # [rad]


def criteria():
    """What the one joint to spare is for: {name: part of the last level}."""
    return {
        "least acceleration": MinimumMotionTask(gain=5.0),
        "least torque": MinimumTorqueTask(),  # the law of Hollerbach and Suh
        "balanced": MinimumTorqueTask() + MinimumMotionTask(10.0, gain=20.0),  # [kg m^2], [1/s]
    }


def move(criterion, way, duration):
    tip = arm.pose(start)[:2]
    task = PositionTask(Line(tip, tip + way, duration=duration, timing=quintic), gain=10.0)
    controller = Controller(arm, task >> criterion, order="acceleration", dt=1e-3)
    return simulate(controller, start, duration=duration, certify=50)


moves = {"short": ([0.2, 0.0], 0.5), "long": ([2.2, 0.2], 2.0)}  # [m], [s]
records = {}
for length, (way, duration) in moves.items():
    print(f"{length} move, {np.linalg.norm(way):.2f} m in {duration:g} s: torque at most and rms, fastest joint")
    for name, criterion in criteria().items():
        record = records[length, name] = move(criterion, way, duration)
        torque = np.linalg.norm(record.tau, axis=1)  # [N m]
        print(
            f"  {name:18}  {torque.max():8.0f} N m  {np.sqrt(np.mean(torque**2)):6.1f} N m"
            f"  {np.abs(record.v).max():6.2f} rad/s  {record.certified} of {record.checked} certified"
            + (f"\n    {record.stopped.reason}" if record.stopped else "")
        )

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import torque_minimisation

    torque_minimisation(sys.argv[1], records)
