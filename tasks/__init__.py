"""Robotics on top of :mod:`hqp`: declare tasks in order of priority, get the motion that honours it.

>>> from tasks import Controller, OrientationTask, PlanarArm, PositionTask
>>> arm = PlanarArm([0.5, 0.5, 0.5])
>>> stack = PositionTask([1.0, 0.2], gain=2.0) >> OrientationTask(0.0, gain=2.0)
>>> controller = Controller(arm, stack, order="velocity", backend="pseudoinverse")
>>> step = controller([1.1, -1.3, -0.7], [0.0, 0.0, 0.0])
>>> step.v.shape, step.ok
((3,), True)
"""

from __future__ import annotations

from .damping import Damping
from .joint_motion import JointMotion
from .limits.acceleration import JointAccelerationLimit
from .limits.position import JointPositionLimit
from .limits.velocity import JointVelocityLimit
from .motion.controller import Controller, Step
from .motion.paths import Chain, Circle, Line, Polygon
from .motion.polynomial import Polynomial
from .motion.record import Record, Stop
from .motion.simulation import simulate
from .motion.timing import cubic, cycloid, harmonic, quintic
from .motion.trajectories import Fixed, Trajectory
from .orientation import OrientationTask
from .part import Order, Part, Tick
from .position import PositionTask
from .posture import PostureTask
from .robots.manipulability import Degrees, VelocityEllipse, manipulability, task_degrees, velocity_ellipse
from .robots.planar import PlanarArm, PlanarState
from .robots.robot import Robot, RobotState
from .singularity import ManipulabilityTask
from .stack import Stack
from .task import TargetTask, Task

__all__ = [
    "Chain",
    "Circle",
    "Controller",
    "Damping",
    "Degrees",
    "Fixed",
    "JointAccelerationLimit",
    "JointMotion",
    "JointPositionLimit",
    "JointVelocityLimit",
    "Line",
    "ManipulabilityTask",
    "Order",
    "OrientationTask",
    "Part",
    "PlanarArm",
    "PlanarState",
    "Polygon",
    "Polynomial",
    "PositionTask",
    "PostureTask",
    "Record",
    "Robot",
    "RobotState",
    "Stack",
    "Step",
    "Stop",
    "TargetTask",
    "Task",
    "Tick",
    "Trajectory",
    "VelocityEllipse",
    "cubic",
    "cycloid",
    "harmonic",
    "manipulability",
    "quintic",
    "simulate",
    "task_degrees",
    "velocity_ellipse",
]
