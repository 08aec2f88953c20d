r"""Trajectories: desired positions in time, fixed or moving, with velocity and acceleration for the feed-forward.

Every target is a function of time. Those that move are in :mod:`~tasks.targets.paths`, a curve and a timing law, and
in :mod:`~tasks.targets.polynomial`, from boundary conditions; a function of your own will do as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.arrays import real_array
from hqp.errors import brief

from ..base.checks import Array, finite, numbers
from ..base.live import Live, structure


@runtime_checkable
class Trajectory(Protocol):
    """A function of time: ``trajectory(t)`` gives position, velocity and acceleration, each (rows,)."""

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]: ...


class Target(Live):
    """Base of all targets here: functions of time whose numbers stay, as much is computed from them beforehand.

    Attributes
    ----------
    known : bool
        Whether it gives three float arrays of the same shapes at all times, so that nothing is to be checked at a tick.
    """

    known: bool = True
    _instead = "make a new one, and set the target of the task to it"


class Fixed(Target):
    """A constant target.

    Parameters
    ----------
    target : array, shape (rows,)
        In the unit of the task: [m] or [rad].

    Examples
    --------
    >>> from tasks import Fixed
    >>> Fixed([0.3, 0.4])(7.0)
    (array([0.3, 0.4]), array([0., 0.]), array([0., 0.]))
    """

    target: Array = structure()

    def __init__(self, target: ArrayLike) -> None:
        self.target = np.atleast_1d(finite(target, "target"))
        if self.target.ndim != 1:
            raise InvalidInput(f"target has shape {self.target.shape}; it must have one axis")
        self._sample = (self.target, *np.zeros((2, len(self.target))))

    @classmethod
    def of(cls, target: Array) -> Fixed:
        """A constant target of numbers that have been checked, shape (rows,)."""
        fixed = cls.__new__(cls)
        vars(fixed).update(target=target, _sample=(target, *np.zeros((2, len(target)))), _sealed=True)
        return fixed

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        return self._sample

    def __repr__(self) -> str:
        return str(self.target.tolist())


class Setpoint(Target):
    """A target set by the caller, as in teleoperation: ``setpoint.move(position)`` before a tick.

    Parameters
    ----------
    value : array, shape (rows,)
        Where it begins, in the unit of the task: [m] or [rad].

    Examples
    --------
    >>> from tasks import PositionTask, Setpoint
    >>> hand = Setpoint([0.3, 0.4])
    >>> task = PositionTask(hand, gain=5.0)
    >>> hand.move([0.3, 0.5])  # before a tick
    >>> hand(0.0)[0]
    array([0.3, 0.5])
    """

    def __init__(self, value: ArrayLike) -> None:
        self._value = np.atleast_1d(np.array(finite(value, "setpoint")))
        self._velocity, self._acceleration = np.zeros((2, len(self._value)))
        self._moves = False

    def move(self, value: ArrayLike, velocity: ArrayLike | None = None, acceleration: ArrayLike | None = None) -> None:
        """Set the target and, if known, its velocity and acceleration (default: 0).

        NaN is accepted, because a device may send it: the next tick is then INVALID, and moves nothing.

        Raises
        ------
        InvalidInput
            If a part has not the shape that the setpoint began with, or an acceleration comes without a velocity.
        """
        moves = velocity is not None
        if not moves and acceleration is not None:
            raise InvalidInput("setpoint: an acceleration is given without a velocity; give both")
        where = alike(value, self._value, "setpoint")
        if not moves and not self._moves:
            self._value[:] = where
            return
        rate = 0.0 if velocity is None else alike(velocity, self._value, "setpoint: velocity")
        change = 0.0 if acceleration is None else alike(acceleration, self._value, "setpoint: acceleration")
        self._value[:], self._velocity[:], self._acceleration[:], self._moves = where, rate, change, moves

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        return self._value, self._velocity, self._acceleration

    def __repr__(self) -> str:
        return f"Setpoint({self._value.tolist()})"


def alike(value: Any, model: Array, what: str) -> Array:
    """`value` as numbers of the shape of `model`, a single number giving an array of one.

    Raises
    ------
    InvalidInput
        If it has another shape.
    """
    plain = type(value) is np.ndarray and value.dtype == np.float64
    array: Array = value if plain else np.atleast_1d(real_array(value, what))
    if array.shape != model.shape:
        raise InvalidInput(f"{what} has shape {array.shape}; it must be {model.shape}, as it began")
    return array


def as_trajectory(target: ArrayLike | Trajectory, rows: int | None, what: str) -> Trajectory:
    """`target` as a trajectory of so many rows (None: any number): numbers stand still, functions of time move.

    Raises
    ------
    InvalidInput
        If a number is not finite, or the target (at t = 0) does not give what a trajectory must.
    """
    if not callable(target):
        given = finite(target, f"{what}: target")
        if given.ndim > 1:
            raise InvalidInput(f"{what}: target has shape {given.shape}; it must have one axis")
        still = Fixed.of(given if given.ndim else given.reshape(1))
        if rows not in (None, len(still.target)):
            raise InvalidInput(f"{what}: target has shape {still.target.shape}; it must be ({rows},)")
        return still
    try:
        sample = tuple(target(0.0))
    except Exception as error:
        raise InvalidInput(f"{what}: target(0.0) raised {type(error).__name__}: {error}") from error
    shapes = [numbers(part, f"{what}: target(0.0)").shape for part in sample]
    size = rows if rows is not None else int(np.prod(shapes[0])) if shapes else 1
    if shapes != [(size,)] * 3:
        if isinstance(target, Fixed):
            raise InvalidInput(f"{what}: target has shape {shapes[0]}; it must be ({size},)")
        raise InvalidInput(
            f"{what}: target(0.0) gives shapes {shapes};"
            f" it must give position, velocity and acceleration, each ({size},)"
        )
    return target if getattr(target, "known", False) else Watched(target, size, what)


class Watched:
    """A user's function of time, whose answers are checked at every tick as they were at first.

    NaN passes: the solver tells of it.

    Parameters
    ----------
    target : Trajectory
    rows : int
    what : str
        Whose target it is, for messages.
    """

    known = True

    def __init__(self, target: Trajectory, rows: int, what: str) -> None:
        self.target, self._shape, self._what = target, (rows,), what

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        r, dr, ddr = three_of(self.target(t), self._what, t)
        return self._part(r, t), self._part(dr, t), self._part(ddr, t)

    def _part(self, value: Any, t: float) -> Array:
        if type(value) is np.ndarray and value.dtype == np.float64 and value.shape == self._shape:
            return value
        part = real_array(value, f"{self._what}: target({t})")
        if part.shape != self._shape:
            raise InvalidInput(f"{self._what}: target({t}) gives the shape {part.shape}; it was {self._shape} at first")
        return part

    def __repr__(self) -> str:
        return repr(self.target)


def three_of(given: Any, what: str, t: float) -> tuple[Any, Any, Any]:
    """What a function of time gives, if it is three things."""
    try:
        value, rate, change = given
    except (TypeError, ValueError):
        raise InvalidInput(f"{what}: target({t}) = {brief(given)}; it must give three arrays, as at first") from None
    return value, rate, change


class Spread:
    """A trajectory of some of three coordinates, the others zero.

    Parameters
    ----------
    trajectory : Trajectory
    axes : sequence of int
        Which, in ascending order.
    """

    known = True

    def __init__(self, trajectory: Trajectory, axes: Sequence[int]) -> None:
        self.trajectory = trajectory
        step = axes[1] - axes[0] if len(axes) > 1 else 1  # two of three, or all, are evenly spaced
        self.columns = slice(axes[0], axes[-1] + 1, step)

    def __call__(self, t: float, /) -> tuple[Array, Array, Array]:
        whole = np.zeros((3, 3))
        whole[:, self.columns] = self.trajectory(t)
        return whole[0], whole[1], whole[2]

    def __repr__(self) -> str:
        return repr(self.trajectory)
