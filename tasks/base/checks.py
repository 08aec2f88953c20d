"""Checks of arguments: each refusal names the thing, its value, and what is allowed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput
from hqp.arrays import Array as Array
from hqp.arrays import real_array
from hqp.errors import brief

F = TypeVar("F")
T = TypeVar("T")

#: The largest gain, limit, length, angle or time: no product or square of two of them leaves the floats.
LARGEST = 1e15
#: What is positive is no less: nor does what is divided by one of them, or by its square.
LEAST = 1.0 / LARGEST
#: Points whose least extent is this share of their largest lie in a plane.
FLAT = 1e-9


def numbers(value: ArrayLike, what: str) -> Array:
    """`value` as a float array of its own (read-only), or InvalidInput."""
    array = real_array(value, what)
    array.flags.writeable = False
    return array


def own_numbers(value: ArrayLike, what: str) -> Array:
    """`value` as a float array, not copied where it is one already, as it is tick after tick."""
    if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.owndata and not value.flags.writeable:
        return value
    return numbers(value, what)


def finite(value: ArrayLike, what: str) -> Array:
    """`value` as an array of finite numbers, none beyond `LARGEST` in size."""
    array = numbers(value, what)
    if (np.abs(array) <= LARGEST).all():  # which no NaN is
        return array
    if not np.isfinite(array).all():
        raise InvalidInput(f"{_first(what, array, ~np.isfinite(array))} must be finite")
    raise InvalidInput(f"{_first(what, array, np.abs(array) > LARGEST)} must be at most {LARGEST:g} in size")


def positive(value: ArrayLike, what: str, *, unit: str = "") -> Array:
    """`value` as an array of positive numbers from `LEAST` to `LARGEST`."""
    array = numbers(value, what)
    wrong = ~((array >= LEAST) & (array <= LARGEST))
    if not wrong.any():
        return array
    tiny = (array > 0) & (array < LEAST)
    if tiny.any():
        raise InvalidInput(f"{_first(what, array, tiny)}{unit and ' ' + unit} must be at least {LEAST:g}")
    raise InvalidInput(f"{_first(what, array, wrong)}{unit and ' ' + unit} must be positive and at most {LARGEST:g}")


def not_negative(value: ArrayLike, what: str, *, unit: str = "") -> Array:
    """`value` as an array of numbers from 0 to `LARGEST`."""
    array = numbers(value, what)
    wrong = ~((array >= 0) & (array <= LARGEST))
    if wrong.any():
        raise InvalidInput(
            f"{_first(what, array, wrong)}{unit and ' ' + unit} must not be negative, and at most {LARGEST:g}"
        )
    return array


def scalar(value: ArrayLike, what: str) -> float:
    """`value` as one number, which may be infinite or NaN."""
    array = numbers(value, what)
    if array.ndim:
        raise InvalidInput(f"{what} has shape {array.shape}; it must be one number")
    return float(array)


def finite_scalar(value: float, what: str) -> float:
    """`value` as one finite number."""
    return scalar(finite(value, what), what)


def positive_scalar(value: float, what: str, *, unit: str = "") -> float:
    """`value` as one positive number from `LEAST` to `LARGEST`."""
    return scalar(positive(value, what, unit=unit), what)


def function(value: F, what: str) -> F:
    """`value`, which must be something to call."""
    if callable(value):
        return value
    raise InvalidInput(f"{what} = {brief(value)} is a {type(value).__name__}; it must be a function")


def per_row(value: Array, rows: int, what: str, of: str = "row") -> Array:
    """`value` for each of so many rows: a scalar stands for all of them."""
    if value.ndim == 0:
        return np.full(rows, float(value))
    if value.shape != (rows,):
        raise InvalidInput(f"{what} has shape {value.shape}; it must be one number, or ({rows},): one a {of}")
    return value


def per_joint(value: ArrayLike, joints: int, what: str, *, unit: str, zero_holds: bool = False) -> Array:
    """`value` for each of so many joints: a positive number, 0 where that holds a joint; an array is infinite for a
    joint that has no limit."""
    array = numbers(value, what)
    free = (array == np.inf) & (array.ndim > 0)
    checked = not_negative if zero_holds else positive
    limits = np.array(per_row(checked(np.where(free, 1.0, array), what, unit=unit), joints, what, "joint"))
    limits[free] = np.inf
    return limits


def pair(value: tuple[T, T], what: str, of: str) -> tuple[T, T]:
    """`value` as two things, which must be a tuple, a list or an array of two."""
    if isinstance(value, tuple | list) or (isinstance(value, np.ndarray) and value.ndim):
        both = tuple(value)
        if len(both) == 2:
            return both
    raise InvalidInput(f"{what} = {brief(value)} must be a pair: {of}")


def position_range(
    value: tuple[ArrayLike, ArrayLike],
    rows: int,
    what: str,
    has: NDArray[np.bool_] | None = None,
    units: Sequence[str] | None = None,
    names: Sequence[str] | None = None,
) -> Array:
    """Lowest and highest positions of so many joints, shape (2, rows), no lowest above its highest.

    Parameters
    ----------
    value : pair of float or array, shape (rows,)
        Numbers count for every joint that has a position, and arrays are to be infinite for the others.
    rows : int
    what : str
        For messages.
    has : array of bool, shape (rows,), optional
        Which joints have a position (default: all).
    units, names : sequence of str, optional
        Of each joint.

    Raises
    ------
    InvalidInput
        Names the joint, what it is given, and what is allowed.
    """
    lowest, highest = pair(value, what, "lowest and highest [rad], [m]")
    has = np.ones(rows, dtype=np.bool_) if has is None else has
    ends = []
    for given, name, free in (lowest, "lowest", -np.inf), (highest, "highest", np.inf):
        own = numbers(given, f"{what}, {name}")
        spread = per_row(own, rows, f"{what}, {name}", "joint")
        ends.append(np.where(has, spread, free) if own.ndim == 0 else np.array(spread))
    low, high = np.array(ends) + 0.0  # which makes 0 of -0
    wrong = ~(low <= high) | (low == np.inf) | (high == -np.inf)
    none = ~has & ((low != -np.inf) | (high != np.inf))
    for joint in np.flatnonzero(wrong | none).tolist():
        called = f"joint {joint}" if names is None else f"joint {names[joint]!r}"
        unit = "" if units is None else f" {units[joint]}"
        rule = (
            "the lowest must not be above the highest, and both may be infinite to their own side"
            if wrong[joint]
            else "it has no position of its own, as it turns without end or is a part of a base; give -inf and inf"
        )
        raise InvalidInput(f"{what}: {called} from {low[joint]:g} to {high[joint]:g}{unit}; {rule}")
    return np.array([low, high])


def suggestion(name: str, names: Iterable[str]) -> str:
    """Alternatives to an unknown name, to end its refusal: similar names, or all of them if they are few."""
    known = list(names)
    close = get_close_matches(name, known, n=3, cutoff=0.5)
    close = close or [other for other in known if name.lower() in other.lower()][:3]
    if close:
        return f"; did you mean {' or '.join(map(repr, close))}?"
    return f"; there are {', '.join(known)}" if 0 < len(known) <= 40 else f"; it has {len(known)} others"


def _first(what: str, array: Array, wrong: NDArray[np.bool_]) -> str:
    """The first wrong entry, named by its place: ``task 'hand': gain, row 1 = -2.0``."""
    if array.ndim == 0:
        return f"{what} = {array}"
    place = tuple(int(i) for i in np.argwhere(wrong)[0])
    return f"{what}[{', '.join(map(str, place))}] = {array[place]}"


def is_flat(points: Array) -> bool:
    """Whether points, shape (k, 3), lie in a plane, and so enclose no volume."""
    if len(points) < 4:
        return True
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return not extents.min() > FLAT * extents.max()
