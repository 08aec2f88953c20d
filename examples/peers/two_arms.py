"""Two arms, put together as one robot, change places with their hands and do not touch each other.

Pink: ``barriers/kukas_self_collision.py``, ``barriers/yumi_self_collision.py``; mink: ``dual_iiwa.py``,
``arm_aloha.py``. Pairs are named by bodies, distances are Coal's, and the limit is a level. The robot is an MJCF made
here; ``PinocchioRobot(model).with_geometry(geometry)`` takes one that Pinocchio has put together.
"""

import mujoco
import numpy as np

from tasks import Controller, JointLimits, PositionTask, PostureTask, SelfCollisionLimit, load_robot, simulate

LINKS = [("z", 0.3), ("y", 0.2), ("z", 0.2), ("y", 0.2), ("z", 0.2), ("y", 0.15), ("z", 0.1)]  # axis, length [m]
AXES = {"y": "0 1 0", "z": "0 0 1"}


def arm(side: str, y: float) -> str:
    """Seven joints, a capsule a link."""
    text, height = f'<body name="{side}" pos="0 {y} 0"><geom size=".05"/>', 0.0
    for i, (axis, length) in enumerate(LINKS):
        text += (
            f'<body name="{side}{i}" pos="0 0 {height}"><joint name="{side}{i}" axis="{AXES[axis]}" range="-170 170"/>'
        )
        text += f'<geom type="capsule" size=".04" fromto="0 0 .02 0 0 {length - 0.02}"/>'
        height = length
    return text + f'<site name="{side}_hand" pos="0 0 {height}"/>' + "</body>" * (len(LINKS) + 1)


model = mujoco.MjModel.from_xml_string(
    f"<mujoco><worldbody>{arm('left', 0.2)}{arm('right', -0.2)}</worldbody></mujoco>"
)
robot = load_robot(model, body=["left", "right"], velocity_limit=2.0)
bent = {f"{side}{i}": angle for side in ("left", "right") for i, angle in {1: 0.7, 3: 1.0, 5: 0.6}.items()}
q = robot.configuration(bent)

pairs = [(f"left{i}", f"right{j}") for i in range(2, 7) for j in range(2, 7)]
apart = SelfCollisionLimit(pairs, margin=0.05, gain=10.0)
hands = [
    PositionTask([0.5, y, z], frame=f"{side}_hand", gain=3.0, name=side)
    for side, y, z in (("left", -0.1, 0.65), ("right", 0.1, 0.4))
]
posture = PostureTask(q, gain=1.0)
free = simulate(Controller(robot, JointLimits() >> hands[0] + hands[1] >> posture, dt=5e-3), q, duration=3.0)
record = simulate(Controller(robot, JointLimits() >> apart >> hands[0] + hands[1] >> posture, dt=5e-3), q, duration=3.0)

for name, run in ("without the limit", free), ("with it", record):
    least = min(apart.distances(robot, robot.at(q)).min() for q in run.q)
    away = [np.linalg.norm(run.errors[side][-1]) for side in ("left", "right")]
    print(f"{name}: arms at least {least * 1e3:.1f} mm apart, hands {max(away) * 1e3:.1f} mm off at the end")
