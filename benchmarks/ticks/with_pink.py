"""pink: a weighted QP on Pinocchio's kinematics."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pink
import pinocchio as pin
import qpsolvers
from pink.tasks import ComTask, FrameTask, PostureTask

from hqp.arrays import Array

from .driver import Driver
from .scenes import COM
from .stream import Stream


class Pink(Driver):
    """``pink.solve_ik`` with its default limits, those of joint positions and velocities."""

    def __init__(self, solver: str, stream: Stream) -> None:
        super().__init__(f"pink {solver}", stream)
        scene, self.solver, self.dt = stream.scene, solver, stream.scene.dt
        model = stream.robot.model.copy()
        self.configuration = pink.Configuration(model, model.createData(), stream.robot.home)
        self.q = list(stream.q)
        self.targets = []
        for frame in scene.frames:
            position, rotation = scene.cost(frame, "position", "pose"), scene.cost(frame, "orientation", "pose")
            task = FrameTask(frame, position, rotation, gain=scene.step)
            self.targets.append((task, list(map(pin.SE3, stream.rotations[frame], stream.positions[frame]))))
        for goal in scene.goals:
            if goal.what == "com":
                task = ComTask(np.array([goal.cost, goal.cost, 0.0]), gain=scene.step)
                self.targets.append((task, list(stream.positions[COM])))
        self.tasks = [task for task, _ in self.targets]
        for goal in scene.goals:
            if goal.what == "posture":
                posture = PostureTask(goal.cost, gain=scene.step)
                posture.set_target(stream.robot.home)
                self.tasks.append(posture)

    def tick(self, k: int) -> Array:
        self.configuration.update(self.q[k])
        for task, values in self.targets:
            task.set_target(values[k])
        return pink.solve_ik(self.configuration, self.tasks, self.dt, solver=self.solver)

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
