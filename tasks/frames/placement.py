r"""The base class of position, orientation and pose tasks: a frame is driven to a target pose.

In the axes of the world, with the frame at p, R and its target at :math:`p^d, R^d`,

.. math:: e = (p^d - p, \; \log(R^d R^T)), \qquad J = (J_p, \; J_\omega),

of which a task has the first half, the second half or both. The rotation vector :math:`\log(R^d R^T)` is the shortest
way to turn there, and :math:`\omega = K e` goes along it: the error decays at the rate K, and J loses no rank on the
way, not even at half a turn. In the axes of the frame itself, which turn with it, both halves are multiplied by
:math:`R^T`: a task with all its coordinates asks for the same motion in any axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import one_of
from hqp.errors import brief

from ..base.checks import Array
from ..base.live import structure
from ..robots.robot import Robot
from ..rows.loop_task import LoopTask
from ..rows.site import Move, kept_up
from ..targets.trajectories import Spread
from ..targets.turns import AboutZ
from .frame_task import FrameTask, Reading

if TYPE_CHECKING:
    from ..base.loops import Call, Table
    from ..rows.plan import Plan
    from ..rows.site import Site

#: Along which axes a task is written down.
Reference = Literal["world", "local", "local_world_aligned"]
#: Some of the coordinates: their names, ``"xz"``, or a truth for each.
Mask = str | Sequence[bool]


class PlacementTask(FrameTask, LoopTask):
    """Base of position, orientation and pose tasks.

    Parameters
    ----------
    mask : tuple of int
        The coordinates to be controlled, of those the task has.
    reference : {"world", "local", "local_world_aligned"}
        The axes of the world (or of `relative_to`), or those of the frame itself, which turn with it.
        "local_world_aligned" is Pinocchio's name for the former; see :class:`tasks.PoseTask` for the difference.
    frame, relative_to, gain, damping_ratio, weight, cap, deceleration, name
        See :class:`~tasks.frames.frame_task.FrameTask`.

    Attributes
    ----------
    position : Trajectory or None
        The target of its origin [m]; None if that is free.
    rotation : RotationTrajectory or None
        The target rotation; None if it is free.
    """

    position: Any = None
    rotation: Any = None
    rows: int = structure()
    mask: tuple[int, ...] = structure()
    reference: Reference = structure()

    def __init__(
        self,
        *,
        mask: tuple[int, ...],
        reference: Reference,
        frame: str | None,
        relative_to: str | None,
        gain: ArrayLike,
        damping_ratio: float,
        weight: ArrayLike,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None,
    ) -> None:
        self._call(name)
        self.reference: Reference = as_reference(reference, self.full_name())
        self.mask, self.rows = mask, len(mask)
        super().__init__(
            frame,
            relative_to,
            gain=gain,
            damping_ratio=damping_ratio,
            weight=weight,
            cap=cap,
            deceleration=deceleration,
            name=name,
        )

    def plan(self, site: Site) -> Plan:
        """One loop; the target is written every tick where it moves."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels import placement as loops

        target, law = np.zeros(loops.TARGET_SIZE), site.law(self)
        places = Places.of(target)
        moves = site.follow(self, ("target", "position", "rotation"), lambda: self._keep_up(places), self._goals)
        call = Call(
            loops.write_placement,
            law,
            self.block(site),
            target,
            site.shared.work,
            self.axes,
            self.position is not None,
            self.rotation is not None,
            isinstance(self.rotation, AboutZ),
            np.array(self.mask, dtype=np.int64),
        )
        return Plan((call,), moves, curvature=self._curvature(site, law), bound=self._bound())

    def _goals(self) -> tuple[object, ...]:
        """What it is to come to: its position, its rotation, or both."""
        return tuple(goal for goal in (self.position, self.rotation) if goal is not None)

    def _curvature(self, site: Site, law: Table) -> Call | None:
        """One loop more, for the curvature."""
        from ..rows.curvature import curvature_call
        from .kernels import curvature as kernels

        first, mask = (0 if self.position is not None else 3), np.array(self.mask, dtype=np.int64)
        told = law, self.axes, self.rotation is not None, first, mask
        return curvature_call(site, kernels.placement_curvature, self.motion_curvature(site), kernels.WORK_SIZE, *told)

    def _bound(self) -> Any:
        """The loop that bounds the curvature; None if the coordinates that the task lacks have a part in it."""
        from .kernels import placement as loops
        from .kernels.bounds import bound_placement

        angular = [i for i in self.mask if i >= 3 or self.position is None]
        simple = self.axes == loops.WORLD and self.relative_to is None and len(angular) in (0, 3)
        return bound_placement if simple else None

    def reading(self) -> Reading | None:
        first = 0 if self.position is not None else 3
        return Reading(self.axes, np.eye(6)[[first + i for i in self.mask]])

    def desired_velocity(self, t: float) -> Array:
        velocity = np.zeros(6)
        for own, goal in (slice(0, 3), self.position), (slice(3, 6), self.rotation):
            if goal is not None:
                velocity[own] = goal(t)[1]
        return velocity

    def _keep_up(self, places: Places) -> tuple[Move, ...]:
        """Keep the target up to date."""
        position, rotation, moves = self.position, self.rotation, tuple[Move, ...]()
        if isinstance(position, Spread):
            moves += kept_up(position.trajectory, *(part[position.columns] for part in places.point))
        elif position is not None:
            moves += kept_up(position, *places.point)
        if isinstance(rotation, AboutZ):
            moves += kept_up(rotation.angle, *places.angle)
        elif rotation is not None:
            moves += kept_up(rotation, *places.turn)
        return moves

    @property
    def axes(self) -> int:
        """Its axes, as loops know them: spatial ones go with the point that is passing the origin of the world."""
        from .kernels import placement as loops

        if self.reference == "local":
            return loops.LOCAL
        spatial = self.reference == "world" and self.position is not None and self.rotation is not None
        return loops.SPATIAL if spatial else loops.WORLD

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        names = [(axis, "m") for axis in "xyz"] if self.position is not None else []
        if self.rotation is not None:
            names += [(f"r{axis}" if names else axis, "rad") for axis in "xyz"]
        return [names[i] for i in self.mask]

    def check_planar(self) -> None:
        if self.reference == "local":
            raise InvalidInput(f"{self.full_name()}: a planar arm knows the axes of the world only")
        if self.position is not None and 2 in self.mask:
            raise InvalidInput(f"{self.full_name()}: a planar arm has no z; give x and y")
        if self.rotation is not None and not isinstance(self.rotation, AboutZ):
            raise InvalidInput(f"{self.full_name()}: a planar arm turns about z only; give one angle [rad]")

    def _shown(self) -> list[str]:
        return [*super()._shown(), *([] if self.reference == "world" else [f"reference={self.reference!r}"])]


class Places(NamedTuple):
    """Where the loop reads a target with its first and second derivative; see :mod:`tasks.frames.kernels.placement`."""

    point: tuple[Array, Array, Array]
    turn: tuple[Array, Array, Array]
    angle: tuple[Array, Array, Array]

    @classmethod
    def of(cls, target: Array) -> Places:
        """The parts of the array that the loop is given."""
        from .kernels import placement as loops

        p, v, a = target[loops.P : loops.R].reshape(3, 3)
        R = target[loops.R : loops.OMEGA].reshape(3, 3)
        omega, alpha = target[loops.OMEGA : loops.ALPHA], target[loops.ALPHA : loops.TURNED]
        return cls((p, v, a), (R, omega, alpha), (target[loops.TURNED :], omega[2:], alpha[2:]))


def as_reference(value: str, what: str) -> Reference:
    """`value`, which must name some axes."""
    found: Reference = one_of(value, get_args(Reference), f"{what}: reference")  # type: ignore[assignment]
    return found


def chosen(mask: Mask | None, names: Sequence[str], what: str) -> tuple[int, ...]:
    """Which coordinates a mask chooses, in order; all, if there is none.

    Raises
    ------
    InvalidInput
        If a name is unknown or comes twice, there is not one truth a coordinate, or none is chosen.
    """
    if mask is None:
        return tuple(range(len(names)))
    if isinstance(mask, str):
        words = mask.split() if " " in mask or mask in names else list(mask)
        unknown = [word for word in words if word not in names]
        if unknown or len(set(words)) != len(words) or not words:
            raise InvalidInput(f"{what}: mask = {mask!r}; it must name some of {', '.join(names)}, each once")
        return tuple(sorted(map(list(names).index, words)))
    try:
        truths = list(mask)
    except TypeError:
        truths = [mask]  # type: ignore[list-item]
    if len(truths) != len(names) or not all(isinstance(t, bool | np.bool_) for t in truths) or not any(truths):
        raise InvalidInput(
            f"{what}: mask = {brief(truths)}; it must say True or False of {', '.join(names)}, and True once"
        )
    return tuple(int(i) for i in np.flatnonzero(truths))
