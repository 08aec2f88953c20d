"""The rows of a spatial robot at velocity order, written by one compiled call a tick.

A tick of an arm takes Pinocchio and the solver some microseconds each; Python objects and small arrays in between
would take ten times that. So what the tasks and limits of this package say is put down once, as a list of numbers a
part, and :mod:`tasks.kernels.rows` writes all rows from it. Parts which it does not know write theirs as always, and so
does every part at acceleration order and on other robots: the two ways say the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._checks import Array, per_row
from .center_of_mass import CenterOfMassTask
from .inequality import AtLeast, AtMost, Inequality, Within
from .kernels import layout as at
from .limits.acceleration import JointAccelerationLimit
from .limits.cartesian import BoxLimit
from .limits.envelope import Envelope
from .limits.joint_limits import JointLimits
from .limits.position import JointPositionLimit
from .limits.velocity import JointVelocityLimit
from .motion.trajectories import Fixed
from .motion.turns import FixedRotation
from .orientation import OrientationTask
from .part import Part
from .place import PlaceTask
from .pose import PoseTask
from .position import PositionTask
from .posture import PostureTask
from .task import Task

#: One part, the rows it owns, and the bounds.
View = tuple[Part, Array | None, Array, Array]
#: Writes this tick's target of a part.
Update = Callable[[float], None]

PLACES = (PositionTask, OrientationTask, PoseTask)
INEQUALITIES = (AtLeast, AtMost, Within, BoxLimit)
AXES = {"world": at.WORLD, "local_world_aligned": at.WORLD, "local": at.LOCAL}


class CompiledRows:
    """Those parts of a stack which the kernel can write, on one robot.

    Parameters
    ----------
    views : iterable of (Part, A, lower, upper)
        All parts of the stack, and the rows that they own.
    robot : PinocchioRobot
    dt : float or None
    envelope : Envelope
        Of the joint limits of the stack.

    Attributes
    ----------
    parts : set of int
        The identities of the parts that are written here.
    """

    def __init__(self, views: Iterable[View], robot: Any, dt: float | None, envelope: Envelope) -> None:
        self._robot, self._dt, self._envelope = robot, dt, envelope
        self._kept: list[Any] = []  # arrays whose addresses the kernel has
        self._updates: list[Update] = []
        self._points = False
        self.parts: set[int] = set()
        lists = []
        for view in views:
            written = self._list(*view)
            if written is not None:
                lists.append(written)
                self.parts.add(id(view[0]))
        self._q, self._v = np.zeros(robot.nq), np.zeros(robot.nv)
        table = np.array(lists, dtype=np.int64).reshape(-1, at.LENGTH)
        jacobians = np.asarray(robot.data.J)
        head = [robot.nv, *map(self._address, (self._q, self._v, jacobians)), len(table), self._address(table)]
        place = self._address(np.array(head, dtype=np.int64)), self._address(np.zeros(48))
        self._run = partial(_kernel(), *place)

    def write(self, state: Any, t: float) -> None:
        """Write the rows of these parts for this state and time t [s]."""
        self._q[:], self._v[:] = state.q, state.v
        for update in self._updates:
            update(t)
        if self._points:
            self._robot.compute_center_of_mass(self._q)
        state.ready()
        self._run()

    def _address(self, array: NDArray[Any]) -> int:
        """Where an array is; it is kept."""
        self._kept.append(array)
        return int(array.ctypes.data)

    def _list(self, part: Part, A: Array | None, lower: Array, upper: Array) -> list[int] | None:
        """What the kernel is told of a part; None if it does not know it."""
        if type(part) is JointLimits:
            return self._limits(part, lower, upper)
        if isinstance(part, Inequality) and not part.plain and np.isfinite(self._envelope.acceleration).any():
            return None  # it brakes in time, which takes the drift of the frame
        task = part.task if isinstance(part, Inequality) and type(part) in INEQUALITIES else part
        if not isinstance(task, Task):
            return None
        rows = len(lower)
        below, above = (part.below, part.above) if isinstance(part, Inequality) else (np.zeros(()), np.zeros(()))
        gains = np.concatenate([per_row(value, rows, "gain") for value in (task.gain, below, above)])
        head = [0, 0 if A is None else self._address(A), self._address(lower), self._address(upper), rows]
        head.append(self._address(gains))
        if isinstance(task, PlaceTask) and type(task) in PLACES and task.relative_to is None:
            return self._place(task, head)
        if type(task) is CenterOfMassTask and task.relative_to is None:
            return self._point(task, head)
        if type(task) is PostureTask and A is None:
            return self._posture(task, head)
        return None

    def _place(self, task: PlaceTask, head: list[int]) -> list[int]:
        robot = self._robot
        frame = robot.model.frames[robot.frame_index(task.frame)]
        joint = int(frame.parentJoint)
        carried = robot.data.oMi[joint]
        mounted = np.concatenate([np.ravel(frame.placement.rotation), frame.placement.translation])
        support = np.ascontiguousarray(np.array(robot.support(joint), dtype=np.int64).reshape(-1, 2).T)
        both = task.position is not None and task.rotation is not None
        self._kept.append(carried)
        return [
            at.PLACE,
            *head[1:],
            self._address(np.array(task.mask, dtype=np.int64)),
            self._address(self._target(task)),
            self._address(carried.translation),
            at.SPATIAL if both and task.reference == "world" else AXES[task.reference],
            task.position is not None,
            task.rotation is not None,
            self._address(carried.rotation),
            self._address(mounted),
            self._address(support),
            support.shape[1],
        ]

    def _point(self, task: PlaceTask, head: list[int]) -> list[int]:
        data = self._robot.data
        self._points = True
        self._robot.compute_center_of_mass(self._robot.neutral)  # which lays out the arrays
        numbers = [
            self._address(np.array(task.mask, dtype=np.int64)),
            self._address(self._target(task)),
            self._address(data.com[0]),
            self._address(data.Jcom),
        ]
        return _padded([at.POINT, *head[1:], *numbers])

    def _target(self, task: PlaceTask) -> Array:
        """Where it is to be, kept up to date if it moves: p, its velocity, R by rows, omega."""
        target = np.zeros(18)
        position, rotation = task.position, task.rotation
        if position is not None:
            self._keep_up(_copier(position, target[:3], target[3:6]), isinstance(position, Fixed))
        if rotation is not None:
            copier = _copier(rotation, target[6:15].reshape(3, 3), target[15:])
            self._keep_up(copier, isinstance(rotation, FixedRotation))
        return target

    def _keep_up(self, update: Update, fixed: bool) -> None:
        update(0.0)
        if not fixed:
            self._updates.append(update)

    def _posture(self, task: PostureTask, head: list[int]) -> list[int] | None:
        robot, own = self._robot, task.variables(self._robot)
        places = robot.places(own)
        if (places < 0).any():
            return None
        wanted, rate = np.zeros((2, len(own)))
        target = task.target
        alone = task.joints is not None and len(target(0.0)[0]) == len(own)
        if not alone and not isinstance(target, Fixed) and robot.nq != robot.nv:
            return None

        def move(t: float) -> None:
            position, velocity, _ = target(t)
            wanted[:] = position if alone else position[places]
            rate[:] = 0.0 if isinstance(target, Fixed) else velocity if alone else velocity[own]

        self._keep_up(move, isinstance(target, Fixed))
        base = wanted.base
        assert base is not None
        return _padded([at.POSTURE, *head[1:], self._address(places), self._address(base)])

    def _limits(self, part: JointLimits, lower: Array, upper: Array) -> list[int] | None:
        """None where limits beside it have a say in what it allows."""
        robot, envelope, limits = self._robot, self._envelope, part.of(self._robot)
        if set(envelope.limits) != set(limits) or self._dt is None:
            return None
        nothing = np.full(robot.nv, np.inf)
        low, high, speed, acceleration = -nothing, nothing, nothing, nothing
        places, return_speed = np.full(robot.nv, -1), 0.0
        for limit in limits:
            if isinstance(limit, JointPositionLimit):
                low, high = envelope.ranges[limit]
                places, return_speed = robot.places(np.arange(robot.nv)), limit.return_speed
            elif isinstance(limit, JointVelocityLimit):
                speed = limit.largest(robot)
            elif isinstance(limit, JointAccelerationLimit):
                acceleration = limit.largest(robot)
            else:
                return None
        self.parts.update(map(id, limits))
        each = {
            "low": low,
            "high": high,
            "speed": speed,
            "back_speed": envelope.velocity,
            "acceleration": acceleration,
            "braking": envelope.acceleration,
            "return_speed": np.full(robot.nv, return_speed),
            "dt": np.full(robot.nv, self._dt),
        }
        numbers = np.concatenate([each[field] for field in at.FIELDS])
        ends = self._address(lower), self._address(upper)
        return _padded([at.LIMITS, 0, *ends, robot.nv, 0, self._address(places), self._address(numbers)])


def _copier(trajectory: Callable[[float], tuple[Array, Array, Array]], place: Array, rate: Array) -> Update:
    def update(t: float) -> None:
        place[:], rate[:], _ = trajectory(t)

    return update


def _padded(numbers: list[int]) -> list[int]:
    return [*numbers, *[0] * (at.LENGTH - len(numbers))]


def _kernel() -> Callable[[int, int], int]:
    """The kernel, compiled or from disk."""
    from hqp.backends.native import SIGNATURE

    from .kernels.rows import write_rows

    warm_up()
    function: Callable[[int, int], int] = write_rows.get_overload(SIGNATURE)
    return function


def warm_up() -> bool:
    """Have the kernel ready: from disk, or compiled now. True if it had to be compiled."""
    from hqp.backends.native import make_ready

    from .kernels.rows import write_rows

    return make_ready(write_rows, "the rows of spatial robots")
