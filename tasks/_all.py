"""All names that :mod:`tasks` exports, imported at once; the command starts without them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .base.rotations import from_rpy, from_xyzw
from .contacts.balance import CapturePointTask, SupportLimit
from .contacts.contact import Contact
from .contacts.dynamics import Dynamics
from .contacts.force_task import CenterOfPressureTask, ForceTask
from .contacts.loop import Loop
from .contacts.momentum import MomentumTask
from .contacts.surface import Surface
from .contacts.torque_task import TorqueTask
from .control.controller import Controller
from .control.rate_loop import loop
from .control.step import Step
from .criteria.gradient import GradientTask
from .criteria.joint_ranges import JointCentringTask
from .criteria.manipulability import DynamicManipulabilityTask, ManipulabilityTask, MinorAxisTask, VelocityRatioTask
from .criteria.motion import KineticEnergyTask, MinimumMotionTask
from .criteria.reconstruction import Reconstructed
from .criteria.torque import MinimumTorqueTask
from .frames.axis import AxisTask
from .frames.center_of_mass import CenterOfMassTask
from .frames.frame_task import FrameTask
from .frames.limits import BoxLimit, FrameVelocityLimit, PlaneLimit
from .frames.look_at import LookAtTask
from .frames.orientation import OrientationTask
from .frames.plane import PlaneTask
from .frames.pose import PoseTask
from .frames.position import PositionTask
from .frames.rolling import OmniwheelTask, RollingTask
from .ik.inverse_kinematics import IkResult, solve_ik
from .joints.coupling import JointCouplingTask
from .joints.damping import Damping
from .joints.freeze import Freeze
from .joints.joint_motion import JointMotion
from .joints.joint_velocity import JointVelocityTask
from .joints.linear import LinearHolonomicTask
from .joints.posture import PostureTask
from .limits.acceleration import JointAccelerationLimit
from .limits.joint_limits import JointLimits
from .limits.position import JointPositionLimit
from .limits.torque import JointTorqueLimit
from .limits.velocity import JointVelocityLimit
from .obstacles.avoidance import AvoidanceTask
from .obstacles.collision import CollisionLimit
from .obstacles.distance import DistanceLimit
from .obstacles.links import LinkCapsule, link_capsules, planar_links
from .obstacles.scene import scene_solids
from .obstacles.self_collision import SelfCollisionLimit
from .obstacles.shapes import Capsule, Sphere
from .obstacles.solids import Box, Polyhedron
from .robots.frame import Frame
from .robots.library import available_robots
from .robots.loading import load_robot
from .robots.manipulability import manipulability, task_degrees, velocity_ellipse
from .robots.planar import PlanarArm
from .robots.robot import Robot, RobotState
from .robots.skeleton import skeleton
from .rows.damped import Damped
from .rows.inequality import AtLeast, AtMost, Within
from .rows.part import Command, Order, Part, Stack, Tick
from .rows.task import TargetTask, Task
from .simulation.ground import Ground
from .simulation.physics import MujocoPlant
from .simulation.record import Record
from .simulation.rigid import RigidContactPlant
from .simulation.schedule import Change, Switch
from .simulation.simulation import Plant, simulate
from .targets.paths import Chain, Circle, Line, Polygon
from .targets.polynomial import Polynomial
from .targets.timing import cubic, cycloid, harmonic, quintic
from .targets.trajectories import Fixed, Setpoint, Trajectory
from .targets.turns import FixedRotation, PoseSetpoint, RotationSetpoint, RotationTrajectory, Turn
from .view.live import live

if TYPE_CHECKING:
    from .robots.pinocchio import PinocchioRobot


def __getattr__(name: str) -> Any:
    """Import what needs Pinocchio at its first use."""
    if name == "PinocchioRobot":
        from .robots.pinocchio import PinocchioRobot

        return PinocchioRobot
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "AtLeast",
    "AtMost",
    "AvoidanceTask",
    "AxisTask",
    "Box",
    "BoxLimit",
    "Capsule",
    "CapturePointTask",
    "CenterOfMassTask",
    "CenterOfPressureTask",
    "Chain",
    "Change",
    "Circle",
    "CollisionLimit",
    "Command",
    "Contact",
    "Controller",
    "Damped",
    "Damping",
    "DistanceLimit",
    "DynamicManipulabilityTask",
    "Dynamics",
    "Fixed",
    "FixedRotation",
    "ForceTask",
    "Frame",
    "FrameTask",
    "FrameVelocityLimit",
    "Freeze",
    "GradientTask",
    "Ground",
    "IkResult",
    "JointAccelerationLimit",
    "JointCentringTask",
    "JointCouplingTask",
    "JointLimits",
    "JointMotion",
    "JointPositionLimit",
    "JointTorqueLimit",
    "JointVelocityLimit",
    "JointVelocityTask",
    "KineticEnergyTask",
    "Line",
    "LinearHolonomicTask",
    "LinkCapsule",
    "LookAtTask",
    "Loop",
    "ManipulabilityTask",
    "MinimumMotionTask",
    "MinimumTorqueTask",
    "MinorAxisTask",
    "MomentumTask",
    "MujocoPlant",
    "OmniwheelTask",
    "Order",
    "OrientationTask",
    "Part",
    "PinocchioRobot",
    "PlanarArm",
    "PlaneLimit",
    "PlaneTask",
    "Plant",
    "Polygon",
    "Polyhedron",
    "Polynomial",
    "PoseSetpoint",
    "PoseTask",
    "PositionTask",
    "PostureTask",
    "Reconstructed",
    "Record",
    "RigidContactPlant",
    "Robot",
    "RobotState",
    "RollingTask",
    "RotationSetpoint",
    "RotationTrajectory",
    "SelfCollisionLimit",
    "Setpoint",
    "Sphere",
    "Stack",
    "Step",
    "SupportLimit",
    "Surface",
    "Switch",
    "TargetTask",
    "Task",
    "Tick",
    "TorqueTask",
    "Trajectory",
    "Turn",
    "VelocityRatioTask",
    "Within",
    "available_robots",
    "cubic",
    "cycloid",
    "from_rpy",
    "from_xyzw",
    "harmonic",
    "link_capsules",
    "live",
    "load_robot",
    "loop",
    "manipulability",
    "planar_links",
    "quintic",
    "scene_solids",
    "simulate",
    "skeleton",
    "solve_ik",
    "task_degrees",
    "velocity_ellipse",
]
