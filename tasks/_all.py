"""All that :mod:`tasks` offers, imported at once; the command begins without."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .axis import AxisTask
from .center_of_mass import CenterOfMassTask
from .coupling import JointCouplingTask
from .criteria.gradient import GradientTask
from .criteria.joint_ranges import JointCentringTask
from .criteria.manipulability import DynamicManipulabilityTask, ManipulabilityTask, VelocityRatioTask
from .criteria.motion import KineticEnergyTask, MinimumMotionTask
from .criteria.torque import MinimumTorqueTask
from .damped import Damped
from .damping import Damping
from .frame_task import FrameTask
from .inequality import AtLeast, AtMost, Within
from .inverse_kinematics import IkResult, solve_ik
from .joint_motion import JointMotion
from .limits.acceleration import JointAccelerationLimit
from .limits.cartesian import BoxLimit, FrameVelocityLimit, PlaneLimit
from .limits.joint_limits import JointLimits
from .limits.position import JointPositionLimit
from .limits.torque import JointTorqueLimit
from .limits.velocity import JointVelocityLimit
from .look_at import LookAtTask
from .motion.controller import Controller, Step
from .motion.paths import Chain, Circle, Line, Polygon
from .motion.physics import MujocoPlant
from .motion.polynomial import Polynomial
from .motion.record import Record, Stop
from .motion.simulation import Change, Plant, simulate
from .motion.timing import cubic, cycloid, harmonic, quintic
from .motion.trajectories import Fixed, Setpoint, Trajectory
from .motion.turns import FixedRotation, PoseSetpoint, RotationSetpoint, RotationTrajectory, Turn
from .obstacles.avoidance import AvoidanceTask
from .obstacles.distance import DistanceLimit
from .obstacles.links import LinkCapsule, planar_links
from .obstacles.self_collision import SelfCollisionLimit
from .obstacles.shapes import Capsule, Sphere
from .orientation import OrientationTask
from .part import Command, Order, Part, Tick
from .plane import PlaneTask
from .pose import PoseTask
from .position import PositionTask
from .posture import PostureTask
from .reconstruction import Reconstructed
from .robots.frame import Frame
from .robots.library import available_robots
from .robots.loading import load_robot
from .robots.manipulability import Degrees, VelocityEllipse, manipulability, task_degrees, velocity_ellipse
from .robots.planar import PlanarArm, PlanarState
from .robots.robot import Robot, RobotState
from .robots.skeleton import skeleton
from .rotations import from_rpy, from_xyzw
from .stack import Stack
from .task import TargetTask, Task

if TYPE_CHECKING:
    from .robots.pinocchio import PinocchioRobot


def __getattr__(name: str) -> Any:
    """What needs Pinocchio is imported when asked for."""
    if name == "PinocchioRobot":
        from .robots.pinocchio import PinocchioRobot

        return PinocchioRobot
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "AtLeast",
    "AtMost",
    "AvoidanceTask",
    "AxisTask",
    "BoxLimit",
    "Capsule",
    "CenterOfMassTask",
    "Chain",
    "Change",
    "Circle",
    "Command",
    "Controller",
    "Damped",
    "Damping",
    "Degrees",
    "DistanceLimit",
    "DynamicManipulabilityTask",
    "Fixed",
    "FixedRotation",
    "Frame",
    "FrameTask",
    "FrameVelocityLimit",
    "GradientTask",
    "IkResult",
    "JointAccelerationLimit",
    "JointCentringTask",
    "JointCouplingTask",
    "JointLimits",
    "JointMotion",
    "JointPositionLimit",
    "JointTorqueLimit",
    "JointVelocityLimit",
    "KineticEnergyTask",
    "Line",
    "LinkCapsule",
    "LookAtTask",
    "ManipulabilityTask",
    "MinimumMotionTask",
    "MinimumTorqueTask",
    "MujocoPlant",
    "Order",
    "OrientationTask",
    "Part",
    "PinocchioRobot",
    "PlanarArm",
    "PlanarState",
    "PlaneLimit",
    "PlaneTask",
    "Plant",
    "Polygon",
    "Polynomial",
    "PoseSetpoint",
    "PoseTask",
    "PositionTask",
    "PostureTask",
    "Reconstructed",
    "Record",
    "Robot",
    "RobotState",
    "RotationSetpoint",
    "RotationTrajectory",
    "SelfCollisionLimit",
    "Setpoint",
    "Sphere",
    "Stack",
    "Step",
    "Stop",
    "TargetTask",
    "Task",
    "Tick",
    "Trajectory",
    "Turn",
    "VelocityEllipse",
    "VelocityRatioTask",
    "Within",
    "available_robots",
    "cubic",
    "cycloid",
    "from_rpy",
    "from_xyzw",
    "harmonic",
    "load_robot",
    "manipulability",
    "planar_links",
    "quintic",
    "simulate",
    "skeleton",
    "solve_ik",
    "task_degrees",
    "velocity_ellipse",
]
