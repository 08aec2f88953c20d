"""Which limit holds which task back? The multipliers of a level answer, row by row."""

import numpy as np

from hqp import Side
from tasks import (
    Controller,
    JointAccelerationLimit,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    PostureTask,
)

arm = PlanarArm([0.4, 0.4, 0.4, 0.3])
stack = (
    JointVelocityLimit(1.0) + JointAccelerationLimit(20.0)
    >> PositionTask([0.9, 0.8], gain=2.0)
    >> OrientationTask(np.pi / 4, gain=2.0)
    >> PostureTask(np.zeros(4), gain=1.0)
)
controller = Controller(arm, stack, order="velocity", dt=0.02)
step = controller(np.radians([45.0, 35.0, -70.0, -30.0]), v=np.array([0.1, 0.8, -0.1, -0.2]))
solution = step.solution
print("joint velocities", step.v.round(4) + 0.0, "rad/s; proved:", solution.certify().ok)

limits = [f"{what} limit of joint {joint}" for what in ("velocity", "acceleration") for joint in (1, 2, 3, 4)]
sides = {Side.LOWER: "at its lower bound", Side.UPPER: "at its upper bound", Side.EQUALITY: "an equality"}

for k, level in enumerate(solution.levels[1:], start=1):
    print(f"\nlevel {k}, {level.name}: residual {level.residual_norm:.4f}")
    holding = np.flatnonzero(np.abs(level.multipliers) > 1e-6)
    for row in holding:
        above, inside = solution.hierarchy.locate(int(row))
        holder = solution.levels[above]
        name = limits[inside] if above == 0 else f"{holder.name}, row {inside}"
        print(f"    held back by the {name}, {sides[Side(holder.active[inside])]}: {level.multipliers[row]:+.4f}")
    if not len(holding):
        print("    held back by nothing")
