"""pink: a weighted QP on Pinocchio's kinematics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pink
import pinocchio as pin
import qpsolvers
from pink.limits import AccelerationLimit, ConfigurationLimit, VelocityLimit
from pink.tasks import ComTask, FrameTask, PostureTask

from hqp.arrays import Array

from .driver import Driver
from .scenes import COM
from .stream import Stream


class Pink(Driver):
    """``pink.solve_ik`` with its default limits, those of joint positions and velocities.

    Parameters
    ----------
    solver : str
    stream : Stream
    lm_damping : float
        Of the tasks of frames: what grows with the square of the error.
    acceleration : float, optional
        What the joints keep, too [rad/s^2].
    name : str
        What stands behind that of the solver.
    **options
        Of ``pink.solve_ik``.
    """

    def __init__(
        self,
        solver: str,
        stream: Stream,
        *,
        lm_damping: float = 0.0,
        acceleration: float | None = None,
        name: str = "",
        **options: Any,
    ) -> None:
        super().__init__(f"pink {solver}{name}", stream)
        scene, self.solver, self.dt, self.options = stream.scene, solver, stream.scene.dt, options
        model = stream.robot.model.copy()
        if stream.robot.velocity_limit is not None:
            model.velocityLimit = stream.robot.velocity_limit
        self.accelerations: list[AccelerationLimit] = []
        if acceleration is not None:
            self.accelerations = [AccelerationLimit(model, np.full(model.nv, acceleration))]
            self.options = options | {"limits": [ConfigurationLimit(model), VelocityLimit(model), *self.accelerations]}
        self.configuration = pink.Configuration(model, model.createData(), stream.robot.home)
        self.q = list(stream.q)
        self.targets = []
        for frame in scene.frames:
            position, rotation = scene.cost(frame, "position", "pose"), scene.cost(frame, "orientation", "pose")
            task = FrameTask(frame, position, rotation, lm_damping, gain=scene.step)
            self.targets.append((task, list(map(pin.SE3, stream.rotations[frame], stream.positions[frame]))))
        for goal in scene.goals:
            if goal.what == "com":
                task = ComTask(np.array([goal.cost, goal.cost, 0.0]), gain=scene.step)
                self.targets.append((task, list(stream.positions[COM])))
        self.tasks = [task for task, _ in self.targets]
        for goal in scene.goals:
            if goal.what == "posture":
                posture = PostureTask(goal.cost, gain=scene.posture_step)
                posture.set_target(stream.robot.home)
                self.tasks.append(posture)

    def stand(self, k: int, q: Array, v: Array) -> None:
        super().stand(k, q, v)
        for limit in self.accelerations:
            limit.set_last_integration(v, self.dt)

    def tick(self, k: int) -> Array:
        self.configuration.update(self.q[k])
        for task, values in self.targets:
            task.set_target(values[k])
        return pink.solve_ik(self.configuration, self.tasks, self.dt, solver=self.solver, **self.options)

    def stages(self, k: int) -> Iterator[None]:
        self.configuration.update(self.q[k])
        yield
        for task, values in self.targets:
            task.set_target(values[k])
        problem = pink.build_ik(self.configuration, self.tasks, self.dt)
        yield
        qpsolvers.solve_problem(problem, solver=self.solver)
        yield

    def velocity(self, answer: Array) -> Array:
        return answer
