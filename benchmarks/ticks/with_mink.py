"""mink: a weighted QP on MuJoCo's kinematics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mink
import mujoco
import numpy as np
import qpsolvers

from hqp.arrays import Array

from .driver import Driver
from .scenes import COM
from .stream import Stream
from .urdf import bare, for_mujoco


class Mink(Driver):
    """``mink.solve_ik`` with limits of joint positions and velocities.

    Parameters
    ----------
    solver : str
    stream : Stream
    lm_damping : float
        Of the tasks of frames: what grows with the square of the error.
    name : str
        What stands behind that of the solver.
    **options
        Of ``mink.solve_ik``.
    """

    def __init__(self, solver: str, stream: Stream, *, lm_damping: float = 0.0, name: str = "", **options: Any) -> None:
        super().__init__(f"mink {solver}{name}", stream)
        scene, robot, self.solver, self.dt = stream.scene, stream.robot, solver, stream.scene.dt
        self.options = options
        model = mujoco.MjModel.from_xml_string(for_mujoco(bare(scene.robot, scene.held), robot.base > 0))
        self.configuration = mink.Configuration(model)
        names = [model.joint(i).name for i in range(model.njnt)][1 if robot.base else 0 :]
        order = [robot.joint_names.index(name) for name in names]
        self.columns = [*range(robot.base), *order]  # of MuJoCo's velocities among those of the stream
        self.q = [self.configured(q) for q in stream.q]
        self.turned = robot.base > 0
        self.targets = []
        for frame in scene.frames:
            position, rotation = scene.cost(frame, "position", "pose"), scene.cost(frame, "orientation", "pose")
            task = mink.FrameTask(frame, "body", position, rotation, scene.step, lm_damping)
            places = zip(stream.rotations[frame], stream.positions[frame], strict=True)
            targets = [mink.SE3.from_rotation_and_translation(mink.SO3.from_matrix(R), p) for R, p in places]
            self.targets.append((task, targets))
        for goal in scene.goals:
            if goal.what == "com":
                task = mink.ComTask(np.array([goal.cost, goal.cost, 0.0]), gain=scene.step)
                self.targets.append((task, list(stream.positions[COM])))
        self.tasks = [task for task, _ in self.targets]
        for goal in scene.goals:
            if goal.what == "posture":
                posture = mink.PostureTask(model, goal.cost, gain=scene.posture_step)
                posture.set_target(self.configured(robot.home))
                self.tasks.append(posture)
        speeds = dict(zip(names, np.asarray(robot.velocity_limit)[order], strict=True))
        self.limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, speeds)]

    def configured(self, q: Array) -> Array:
        """A configuration of the stream as MuJoCo has it: joints in its order, the quaternion's scalar first."""
        base = self.stream.robot.base
        if not base:
            return q[self.columns]
        return np.concatenate([q[:3], q[6:7], q[3:6], q[7:][np.array(self.columns[base:]) - base]])

    def tick(self, k: int) -> tuple[int, Array]:
        self.configuration.update(self.q[k])
        for task, values in self.targets:
            task.set_target(values[k])
        return k, mink.solve_ik(
            self.configuration, self.tasks, self.dt, self.solver, limits=self.limits, **self.options
        )

    def stages(self, k: int) -> Iterator[None]:
        self.configuration.update(self.q[k])
        yield
        for task, values in self.targets:
            task.set_target(values[k])
        problem = mink.build_ik(self.configuration, self.tasks, self.dt, limits=self.limits)
        yield
        qpsolvers.solve_problem(problem, solver=self.solver)
        yield

    def velocity(self, answer: tuple[int, Array]) -> Array:
        k, found = answer
        v = np.zeros(len(found))
        v[self.columns] = found
        if self.turned:  # MuJoCo's linear velocity of the base is along the axes of the world
            w, x, y, z = self.q[k][3:7]
            v[:3] = mink.SO3(np.array([w, x, y, z])).inverse() @ v[:3]
        return v
