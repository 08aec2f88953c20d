"""placo: a QP in C++ whose tasks are rows, weighed, or slowed down together."""

import time

import numpy as np
import placo


class Library:
    """``placo.KinematicsSolver`` with limits of joint positions and velocities.

    Options
    -------
    first : str
        The priority of the tasks of the first level, ``"hard"``, ``"soft"`` or ``"scaled"``; others are soft.
    """

    def __init__(self, scene, given, first="soft"):
        self.robot = robot = placo.RobotWrapper(scene["urdf"], placo.Flags.ignore_collisions)
        self.solver = solver = robot.make_solver()
        solver.dt = scene["dt"]
        solver.enable_joint_limits(True)
        solver.enable_velocity_limits(True)
        solver.mask_fbase(scene["base"] == 0)
        self.joints, self.base = scene["joints"], scene["base"]
        for joint, speed in zip(self.joints, given["speed"], strict=True):
            robot.set_velocity_limit(joint, speed)
        self.columns = [robot.get_joint_v_offset(name) for name in self.joints]
        self.configurations = self.configured(given["q"])
        self.targets, self.posture = [], None
        for number, goal in enumerate(scene["goals"]):
            priority = first if goal["level"] == 0 else "soft"
            self.add(goal, f"task {number}", priority, given)

    def configured(self, q):
        """The configurations of the motion as placo has them."""
        base = q.shape[1] - len(self.joints)
        rows = np.tile(self.robot.state.q, (len(q), 1))
        rows[:, :base] = q[:, :base]
        rows[:, [self.robot.get_joint_offset(name) for name in self.joints]] = q[:, base:]
        return list(rows)

    def add(self, goal, name, priority, given):
        """Declare a task, and its targets where it has any: object, attribute, values."""
        what, frame, weights = goal["what"], goal["frame"], [goal["cost"] ** 2]
        positions, rotations = given.get(f"position {frame}"), given.get(f"rotation {frame}")
        if what == "posture":
            task = self.posture = self.solver.add_joints_task()
            self.postures = [dict(zip(self.joints, row, strict=True)) for row in given["posture"].tolist()]
            task.set_joints(self.postures[0])
        elif what == "com":
            task = self.solver.add_com_task(positions[0])
            task.mask.set_axises("xy")
            self.targets.append((task, "target_world", list(positions)))
        elif what == "position":
            task = self.solver.add_position_task(frame, positions[0])
            self.targets.append((task, "target_world", list(positions)))
        elif what == "orientation":
            task = self.solver.add_orientation_task(frame, rotations[0])
            self.targets.append((task, "R_world_frame", list(rotations)))
        else:
            transforms = np.tile(np.eye(4), (len(positions), 1, 1))
            transforms[:, :3, :3], transforms[:, :3, 3] = rotations, positions
            task, weights = self.solver.add_frame_task(frame, transforms[0]), 2 * weights
            self.targets.append((task, "T_world_frame", list(transforms)))
        task.configure(name, priority, *weights)

    def prepare(self, k):
        """What a user has not to do every tick: the posture stands still, and moves as a step here has no gain."""
        if self.posture is not None:
            self.posture.set_joints(self.postures[k])

    def aim(self, k):
        """Set all targets."""
        for task, attribute, values in self.targets:
            setattr(task, attribute, values[k])

    def step(self, k):
        """One tick; raises RuntimeError where it has no answer."""
        self.robot.state.q = self.configurations[k]
        self.aim(k)
        self.robot.update_kinematics()
        return self.solver.solve(False)

    def ordered(self, step):
        """In the order of the motion."""
        return [*step[: self.base], *step[self.columns]]

    def split(self, k):
        """Kinematics, and the solve, in which the rows are written."""
        self.prepare(k)
        self.aim(k)
        laps = [time.perf_counter_ns()]
        try:
            self.robot.state.q = self.configurations[k]
            self.robot.update_kinematics()
            laps.append(time.perf_counter_ns())
            self.solver.solve(False)
        except RuntimeError:
            return [None] * 3
        laps.append(time.perf_counter_ns())
        return [laps[1] - laps[0], None, laps[2] - laps[1]]
