"""roboplan's OInK: a QP in C++ on Pinocchio's kinematics, weighted, or with priorities by projection."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from roboplan.core import CartesianConfiguration, Scene, loadUrdfSceneDescriptionFromXml
from roboplan.optimal_ik import (
    ConfigurationTask,
    ConfigurationTaskOptions,
    FrameTask,
    FrameTaskOptions,
    Oink,
    OinkSettings,
    PositionLimit,
    VelocityLimit,
)

from hqp.arrays import Array

from .driver import Driver
from .stream import Stream
from .urdf import bare


class Roboplan(Driver):
    """``Oink.solveIk`` with limits of joint positions and velocities, of robots whose base is fixed.

    Its costs multiply squares, where those of the others are squared themselves.

    Parameters
    ----------
    solver : str
        Always empty: it has one of its own.
    stream : Stream
    lm_damping : float
        Of the tasks of frames: what grows with the square of the error.
    priorities : bool
        Whether every level of the scene has a priority of its own: a lower one is projected into the null space of
        those above.
    tolerance : float, optional
        Of its QP [rad], which is then solved cold; by default its own, 1e-6, and warm.
    name : str
        What stands behind that of the library.
    """

    def __init__(
        self,
        solver: str,
        stream: Stream,
        *,
        lm_damping: float = 0.0,
        priorities: bool = False,
        tolerance: float | None = None,
        name: str = "",
    ) -> None:
        super().__init__(f"roboplan{solver}{name}", stream)
        scene, robot = stream.scene, stream.robot
        urdf = ET.tostring(bare(scene.robot, scene.held), encoding="unicode")
        self.scene = Scene(scene.robot, loadUrdfSceneDescriptionFromXml(urdf))
        settings = OinkSettings()
        if tolerance is not None:
            settings.eps_abs, settings.max_iter, settings.warm_start = tolerance, 100_000, False
        self.oink = Oink(self.scene, settings)
        self.dt, self.q = scene.dt, list(stream.q)
        self.step = np.zeros(robot.nv)
        self.limits = [PositionLimit(self.oink)]
        if robot.velocity_limit is not None:
            self.limits.append(VelocityLimit(self.oink, scene.dt, robot.velocity_limit))
        self.tasks: list[Any] = []
        self.targets: list[tuple[FrameTask, Sequence[Array]]] = []
        for level, goals in enumerate(scene.levels if priorities else [scene.goals], start=1):
            for frame in dict.fromkeys(goal.frame for goal in goals if goal.frame):
                position, orientation = (
                    sum(goal.cost**2 for goal in goals if goal.frame == frame and goal.what in what)
                    for what in (("position", "pose"), ("orientation", "pose"))
                )
                options = FrameTaskOptions(position, orientation, scene.step, lm_damping=lm_damping, priority=level)
                poses = [_pose(*pose) for pose in zip(stream.positions[frame], stream.rotations[frame], strict=True)]
                task = FrameTask(self.oink, self.scene, CartesianConfiguration("", frame, poses[0]), options)
                self.targets.append((task, poses))
                self.tasks.append(task)
            for goal in goals:
                if goal.what == "posture":
                    weights = np.full(robot.nv, goal.cost**2)
                    slowly = ConfigurationTaskOptions(scene.posture_step, priority=level)
                    self.tasks.append(ConfigurationTask(self.oink, robot.home, weights, slowly))

    def tick(self, k: int) -> Array:
        for task, poses in self.targets:
            task.setTargetFrameTransform(poses[k])
        self.oink.solveIk(self.q[k], self.tasks, self.limits, [], self.step)
        return self.step / self.dt

    def stages(self, k: int) -> Iterator[None]:
        raise NotImplementedError("its parts are not told")

    def velocity(self, answer: Array) -> Array:
        return answer


def _pose(position: Array, rotation: Array) -> Array:
    """As a homogeneous matrix, shape (4, 4)."""
    pose = np.eye(4, order="F")
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose
