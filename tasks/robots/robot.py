"""The public interface to robots: protocols, queries with defaults, and checks.

=======================  =================================================================
:mod:`.abilities`        protocols: what every robot has, and what some have
:mod:`.answers`          queries, each with the default for a robot that lacks the ability
:mod:`.admission`        one check of a user's robot
:mod:`.refusals`         errors for unknown names and joints
=======================  =================================================================
"""

from .abilities import Robot
from .admission import as_robot, check_states
from .answers import (
    Quantity,
    abilities,
    at_rest,
    base,
    bias,
    center_of_mass,
    difference,
    frame_names,
    has_frame,
    home,
    integrate,
    integration,
    inverse_dynamics,
    is_flat,
    joint_names,
    joint_positions,
    joint_reader,
    joint_units,
    limit_of,
    limits_reader,
    manipulability,
    mass_matrix,
    neutral,
    numbered,
    points,
    pose_reader,
    positioned,
    robot_of,
    state_abilities,
    subtraction,
    tells_tip,
    tip,
    towards,
    workspace,
)
from .kinds import on_pinocchio
from .refusals import (
    check_dynamics,
    check_fixed_base,
    check_frame,
    check_joints,
    check_mass_matrix,
    check_positioned,
    joint_index,
)
from .state import RobotState

__all__ = [
    "Quantity",
    "Robot",
    "RobotState",
    "abilities",
    "as_robot",
    "at_rest",
    "base",
    "bias",
    "center_of_mass",
    "check_dynamics",
    "check_fixed_base",
    "check_frame",
    "check_joints",
    "check_mass_matrix",
    "check_positioned",
    "check_states",
    "difference",
    "frame_names",
    "has_frame",
    "home",
    "integrate",
    "integration",
    "inverse_dynamics",
    "is_flat",
    "joint_index",
    "joint_names",
    "joint_positions",
    "joint_reader",
    "joint_units",
    "limit_of",
    "limits_reader",
    "manipulability",
    "mass_matrix",
    "neutral",
    "numbered",
    "on_pinocchio",
    "points",
    "pose_reader",
    "positioned",
    "robot_of",
    "state_abilities",
    "subtraction",
    "tells_tip",
    "tip",
    "towards",
    "workspace",
]
