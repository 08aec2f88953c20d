"""Which limit holds which task back? The solution explains itself, in the words of the stack."""

import numpy as np

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
    JointVelocityLimit(1.0, name="velocity limit") + JointAccelerationLimit(20.0, name="acceleration limit")
    >> PositionTask([0.9, 0.8], gain=2.0)
    >> OrientationTask(np.pi / 4, gain=2.0)
    >> PostureTask(np.zeros(4), gain=1.0)
)
controller = Controller(arm, stack, order="velocity", dt=0.02, damping=None)
step = controller(np.radians([45.0, 35.0, -70.0, -30.0]), v=np.array([0.1, 0.8, -0.1, -0.2]))
solution = step.solution
print("joint velocities", step.v.round(4) + 0.0, "rad/s; proved:", solution.certify().ok)

explanation = solution.explain()
print(f"\n{explanation}")

for level in explanation.levels[1:]:
    print(f"\nlevel {level.level}, {level.name}: {'met' if level.met else 'not met'}, by rank {level.rank}")
    for cause in level.causes:
        print(f"    held back by {cause}: {cause.share:.0%}")
    if not level.causes:
        print("    held back by nothing")
