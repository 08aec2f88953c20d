"""The closed loop of a three-link arm: the tip on a line, then the last link level, with joint limits above both."""

import sys

import numpy as np

from tasks import (
    Controller,
    JointAccelerationLimit,
    JointVelocityLimit,
    Line,
    OrientationTask,
    PlanarArm,
    PositionTask,
    simulate,
)

arm = PlanarArm([0.7, 0.7, 0.3])  # link lengths [m]
start = np.radians([62.0, -90.0, -52.0])
x, y, phi = arm.pose(start)
print(f"start: tip ({x:.3f}, {y:.3f}) m, phi {np.degrees(phi):.1f} deg")

limits = JointVelocityLimit(3.0) + JointAccelerationLimit(30.0)  # [rad/s], [rad/s^2]
position = PositionTask(Line([1.0, 0.0], [1.0, 1.0], duration=3.0), gain=5.0)
orientation = OrientationTask(0.0, gain=5.0)
stack = limits >> position >> orientation

controller = Controller(arm, stack, order="acceleration", dt=2e-3)
record = simulate(controller, start, duration=3.0, certify=10)
print(record)

print("\n  t [s]   tip error [mm]   phi error [deg]   fastest joint [rad/s]")
for k in range(0, len(record) + 1, 250):
    tip = 1e3 * np.linalg.norm(record.errors["position"][k])
    turn = np.degrees(record.errors["orientation"][k, 0])
    print(f"  {record.t[k]:5.2f}   {tip:14.3f}   {turn:15.3f}   {np.abs(record.v[k]).max():21.3f}")

largest = {name: np.abs(getattr(record, name)).max() for name in ("v", "a")}
print(f"\nlargest joint speed {largest['v']:.3f} rad/s, largest joint acceleration {largest['a']:.3f} rad/s^2")

if sys.argv[1:]:  # a folder, for the picture
    from _pictures import planar

    planar(sys.argv[1], "planar_arm.png", record, times=(0.0, 0.5, 1.5, 3.0))
