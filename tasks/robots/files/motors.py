"""The actuators of an MJCF whose limits bound the torque of a joint of the robot, and which are not read."""

from __future__ import annotations

import mujoco

#: Transmissions that act on one joint.
ON_JOINTS = int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)


def motor_limits(mj: mujoco.MjModel, joints: dict[int, str]) -> list[str]:
    """The joints (number, name) with an actuator of limited force that have no limit of their own.

    The force of an actuator is limited by its range of forces, and that of a motor, whose force is its control times a
    constant, by its range of controls. ``actuatorfrcrange`` of a joint is read, and stands for both.
    """
    found = [
        joints[int(mj.actuator_trnid[i, 0])]
        for i in range(mj.nu)
        if mj.actuator_trntype[i] in ON_JOINTS and int(mj.actuator_trnid[i, 0]) in joints and _is_limited(mj, i)
    ]
    return list(dict.fromkeys(found))


def _is_limited(mj: mujoco.MjModel, i: int) -> bool:
    if mj.jnt_actfrclimited[int(mj.actuator_trnid[i, 0])]:
        return False
    fixed = mj.actuator_gaintype[i] == int(mujoco.mjtGain.mjGAIN_FIXED)
    motor = fixed and mj.actuator_biastype[i] == int(mujoco.mjtBias.mjBIAS_NONE)
    return bool(mj.actuator_forcelimited[i] or (motor and mj.actuator_ctrllimited[i]))
