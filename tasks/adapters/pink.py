"""Tasks, barriers and limits of Pink as parts of a stack."""

from __future__ import annotations

from importlib import import_module
from itertools import zip_longest
from typing import Any, Literal
from weakref import WeakKeyDictionary

import numpy as np

from hqp import InvalidInput, MissingPackage
from hqp.errors import brief

from ..base.checks import Array
from ..robots.robot import Robot, on_pinocchio
from .part import Adapted, Rows, Source, damped, least_squares, origin

#: What a barrier of Pink adds to its QP: constraints, and a cost that keeps steps short.
Half = Literal["bounds", "cost"]
#: Below this, Pink leaves the cost of a barrier out.
LEAST_GAIN = 1e-6


def from_pink(given: Any, configuration: Any = None, *, half: Half | None = None, name: str | None = None) -> Adapted:
    """A task, a barrier or a limit of Pink as a part of a stack: certified, explained, and strict.

    Parameters
    ----------
    given : pink.tasks.Task, pink.barriers.Barrier or pink.limits.Limit
        Also of a class of your own. It is evaluated at every tick, so that changes to it take effect at once:
        ``set_target``, ``gain``, ``cost``, ``lm_damping``.
    configuration : pink.Configuration, optional
        Where it is evaluated; required if the object needs a collision model. It is set to the q of every tick.
        By default one is made of the robot of the controller.
    half : {"bounds", "cost"}, optional
        Which half of a barrier with a ``safe_displacement_gain``: its constraints, or the cost that keeps steps short,
        which belongs on a level below. Needed for such a barrier alone.
    name : str, optional
        Its name in explanations (default: its class).

    Returns
    -------
    Adapted
        A part for ``>>`` and ``+``. A task has a row for each entry of its error, times its cost, and nv more where it
        has ``lm_damping``: on one level, that is Pink's own step. Barriers and limits have an inequality a row.

    Raises
    ------
    InvalidInput
        If it is none of these; at work, if no target is set, or the robot is not on Pinocchio.
    MissingPackage
        If Pink is not installed.

    Examples
    --------
    >>> from pink.tasks import FrameTask  # doctest: +SKIP
    >>> hand = FrameTask("panda_hand_tcp", position_cost=1.0, orientation_cost=0.1)  # doctest: +SKIP
    >>> stack = JointLimits() >> from_pink(hand) >> PostureTask(robot.home, gain=1.0)  # doctest: +SKIP
    """
    try:
        pink = import_module("pink")
        tasks, barriers, limits = (import_module(f"pink.{of}") for of in ("tasks", "barriers", "limits"))
    except ImportError:
        raise MissingPackage("from_pink needs Pink: pip install 'hqp[peers]'") from None
    if configuration is not None and not isinstance(configuration, pink.Configuration):
        raise InvalidInput(f"configuration = {brief(configuration)}; it must be a pink.Configuration")
    barrier = isinstance(given, barriers.Barrier)
    if not barrier and half is not None:
        raise InvalidInput(f"half = {brief(half)}; only a barrier has two halves, {type(given).__name__} has not")
    if isinstance(given, tasks.Task):
        return Adapted(Task(given, configuration), bounds=False, name=name)
    if isinstance(given, limits.Limit):
        return Adapted(Bounds(given, configuration), bounds=True, name=name)
    if not barrier:
        raise InvalidInput(f"from_pink takes a task, a barrier or a limit of Pink; this is a {origin(given)}")
    if half not in (None, "bounds", "cost"):
        raise InvalidInput(f"half = {brief(half)}; it must be 'bounds' or 'cost'")
    if half is None and given.safe_displacement_gain > LEAST_GAIN:
        raise InvalidInput(
            f"{type(given).__name__}: safe_displacement_gain = {given.safe_displacement_gain:g} is a cost beside its"
            " constraints; take them apart: half='bounds' for a high level, half='cost' for a low one; or set it to 0"
        )
    if half == "cost":
        return Adapted(Cost(given, configuration), bounds=False, name=name)
    return Adapted(Bounds(given, configuration), bounds=True, name=name)


#: For every robot, the configuration shared by objects without one of their own.
_SHARED: WeakKeyDictionary[Robot, Any] = WeakKeyDictionary()


class _Measured(Source):
    """Base class: an object, and the configuration at which it is evaluated."""

    def __init__(self, given: Any, configuration: Any) -> None:
        self.given, self._configuration, self.kind = given, configuration, type(given).__name__
        self._matched: Robot | None = None

    def at(self, robot: Robot, q: Array) -> Any:
        """The configuration, brought to q."""
        if not on_pinocchio(robot):
            raise InvalidInput(f"{self.kind}: robot = {brief(robot)}; Pink needs the model of a PinocchioRobot")
        configuration = self._configuration
        if configuration is None:
            configuration = _SHARED.get(robot)
            if configuration is None:
                from pink import Configuration

                _SHARED[robot] = configuration = Configuration(robot.model, robot.model.createData(), q)
        elif configuration.model.nv != robot.nv or configuration.model.nq != robot.nq:
            raise InvalidInput(
                f"{self.kind}: its configuration has {configuration.model.nv} joint velocities, the robot {robot.nv}"
            )
        self._match(robot, configuration.model)
        if not np.array_equal(configuration.q, q):
            configuration.update(q)
        return configuration

    def _match(self, robot: Any, model: Any) -> None:
        """Refuse a model of other joints, or of the same in another order: Pink takes them by number."""
        if self._matched is robot:
            return
        own = getattr(self.given, "model", None)  # limits keep the one that they were made of
        for whose, other in ("configuration", model), ("model", own if isinstance(own, type(robot.model)) else model):
            for ours, theirs in zip_longest(_joints(robot.model), _joints(other)):
                if ours != theirs:
                    raise InvalidInput(
                        f"{self.kind}: its {whose} has joint {theirs and theirs[0]!r} where the robot has"
                        f" {ours and ours[0]!r}; make it of robot.model"
                    )
        self._matched = robot


def _joints(model: Any) -> list[tuple[str, int, int]]:
    """Every joint by its name, where it begins in v, and how many positions it has; a free base has any name."""
    joints = zip(model.names[1:], model.joints[1:], strict=True)
    return [
        ("" if joint.shortname() == "JointModelFreeFlyer" else name, joint.idx_v, joint.nq) for name, joint in joints
    ]


class Task(_Measured):
    """A task: the rows of its error times its cost, and those of its damping."""

    def rows(self, robot: Robot, q: Array, dt: float) -> Rows:
        task, configuration = self.given, self.at(robot, q)
        from pink.exceptions import PinkError

        try:
            J, e = task.compute_jacobian(configuration), -task.gain * task.compute_error(configuration)
        except PinkError as error:
            raise InvalidInput(f"{self.kind}: {error}") from error
        if task.cost is not None:
            cost = np.broadcast_to(np.asarray(task.cost, dtype=float), e.shape)
            J, e = cost[:, None] * J, cost * e
        return damped(J, e, task.lm_damping * float(e @ e)) if task.lm_damping else (J, e)


class Bounds(_Measured):
    """A barrier or a limit: inequalities of a step."""

    def rows(self, robot: Robot, q: Array, dt: float) -> Rows:
        found = self.given.compute_qp_inequalities(self.at(robot, q), dt)
        return (np.zeros((0, robot.nv)), np.zeros(0)) if found is None else found


class Cost(_Measured):
    """The cost of a barrier, that steps be short or go to a safe place."""

    def rows(self, robot: Robot, q: Array, dt: float) -> Rows:
        H, c = self.given.compute_qp_objective(self.at(robot, q))
        return least_squares(H, c, self.kind)
