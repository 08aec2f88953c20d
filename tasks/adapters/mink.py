"""Tasks and limits of mink as parts of a stack."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from hqp import InvalidInput, MissingPackage
from hqp.errors import brief

from ..base.checks import Array
from ..robots.robot import Robot
from .joints import MujocoJoints, check_same_joints
from .part import Adapted, Rows, Source, damped, least_squares, origin


def from_mink(given: Any, configuration: Any, *, name: str | None = None) -> Adapted:
    """A task or a limit of mink as a part of a stack: certified, explained, and strict.

    Parameters
    ----------
    given : mink.BaseTask or mink.Limit
        Also of a class of your own. It is evaluated at every tick, so that changes to it take effect at once:
        ``set_target``, ``gain``, ``cost``, ``lm_damping``.
    configuration : mink.Configuration
        Where it is evaluated, on the model that it was made for. It is set to the q of every tick: joints correspond to
        those of the robot by name, a free joint is the floating base, and other joints stay where they are.
    name : str, optional
        Its name in explanations (default: its class).

    Returns
    -------
    Adapted
        A part for ``>>`` and ``+``. A task has a row for each entry of its error, times its cost, and nv more where it
        has ``lm_damping``; a cost of another form has nv rows: on one level, that is mink's own step. Limits have one
        inequality per row.

    Raises
    ------
    InvalidInput
        If it is none of these; at work, if no target is set, a joint of the robot is not in mink's model, or a limit
        was made of a model whose joints are others, or in another order. (Objects that keep no model, such as
        ``mink.VelocityLimit``, are refused where their sizes do not fit.)
    MissingPackage
        If mink is not installed.

    Examples
    --------
    >>> hand = mink.FrameTask("hand", "site", position_cost=1.0, orientation_cost=0.1)  # doctest: +SKIP
    >>> hand.set_target_from_configuration(configuration)  # doctest: +SKIP
    >>> stack = JointLimits() >> from_mink(hand, configuration) >> PostureTask(robot.home, gain=1.0)  # doctest: +SKIP
    """
    try:
        mink = import_module("mink")
    except ImportError:
        raise MissingPackage("from_mink needs mink: pip install 'hqp[peers]'") from None
    if not isinstance(configuration, mink.Configuration):
        raise InvalidInput(f"configuration = {brief(configuration)}; it must be a mink.Configuration")
    if isinstance(given, import_module("mink.tasks").BaseTask):
        return Adapted(Task(given, configuration), bounds=False, name=name)
    if isinstance(given, mink.Limit):
        return Adapted(Bounds(given, configuration), bounds=True, name=name)
    raise InvalidInput(f"from_mink takes a task or a limit of mink; this is a {origin(given)}")


class _Measured(Source):
    """Base of tasks and limits: an object, and the configuration at which it is evaluated."""

    def __init__(self, given: Any, configuration: Any) -> None:
        self.given, self._configuration, self.kind = given, configuration, type(given).__name__
        self._joints: tuple[Robot, MujocoJoints] | None = None

    def at(self, robot: Robot, q: Array) -> tuple[Any, Array]:
        """The configuration, brought to q, and how its velocities follow those of the robot, shape (nv there, nv)."""
        if self._joints is None or self._joints[0] is not robot:
            check_same_joints(getattr(self.given, "model", None), self._configuration.model, self.kind)
            self._joints = robot, MujocoJoints(robot, self._configuration.model, self.kind)
        joints, configuration = self._joints[1], self._configuration
        qpos = joints.qpos(q, configuration.data.qpos)
        if not np.array_equal(configuration.data.qpos, qpos):
            configuration.update(qpos)
        return configuration, joints.velocities(q)


class Task(_Measured):
    """A task: the rows of its weighted error and of its damping, or those of its cost."""

    def rows(self, robot: Robot, q: Array, dt: float) -> Rows:
        from mink.exceptions import MinkError

        configuration, T = self.at(robot, q)
        try:
            residual = self.given.compute_qp_residual(configuration)
            cost = None if residual is not None else self.given.compute_qp_objective(configuration)
        except MinkError as error:
            raise InvalidInput(f"{self.kind}: {error}") from error
        if cost is not None:
            return least_squares(T.T @ cost.H @ T, T.T @ cost.c, self.kind)
        J, e, mu = residual
        if not getattr(self.given, "lm_damping", 0.0):
            return J @ T, e
        whole, target = damped(J, e, mu)
        return whole @ T, target


class Bounds(_Measured):
    """A limit: inequalities of a step."""

    def rows(self, robot: Robot, q: Array, dt: float) -> Rows:
        configuration, T = self.at(robot, q)
        found = self.given.compute_qp_inequalities(configuration, dt)
        if found.inactive:
            return np.zeros((0, robot.nv)), np.zeros(0)
        return found.G @ T, found.h
