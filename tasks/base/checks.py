"""Checks of arguments: each error names the argument, its value, and what is allowed."""

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

#: The largest gain, limit, length, angle or time: products and squares of such numbers do not overflow.
LARGEST = 1e15
#: The least positive number: a quotient by it, or by its square, does not overflow either.
LEAST = 1.0 / LARGEST
#: Fewer numbers than these are checked one by one, which costs less than the calls of numpy.
MANY = 10
#: Points lie in a plane if their least extent is at most this share of their largest.
FLAT = 1e-9


def numbers(value: ArrayLike, what: str) -> Array:
    """`value` as a new read-only float array; raises InvalidInput if it is none."""
    array = real_array(value, what)
    array.setflags(write=False)
    return array


def own_numbers(value: ArrayLike, what: str) -> Array:
    """`value` as a float array, not copied if it is one already, as at every tick."""
    if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.owndata and not value.flags.writeable:
        return value
    return numbers(value, what)


def fill(out: Array, value: ArrayLike, what: str, *, spread: bool = False) -> None:
    """Write what a method returned this tick to `out`: numbers of its shape, or with `spread` one for all.

    Raises
    ------
    InvalidInput
        If it is anything else. NaN is written, for the solver to report.
    """
    array = value if type(value) is np.ndarray and value.dtype == np.float64 else real_array(value, what)
    if array.shape != out.shape and not (spread and array.ndim == 0):
        raise InvalidInput(f"{what} has shape {array.shape}; it must be {out.shape}{' or ()' if spread else ''}")
    out[...] = array


def finite(value: ArrayLike, what: str) -> Array:
    """`value` as an array of finite numbers, none beyond `LARGEST` in size."""
    array = numbers(value, what)
    if array.size < MANY:
        within = all(-LARGEST <= entry <= LARGEST for entry in array.ravel().tolist())  # False for NaN
    else:
        within = bool((np.abs(array) <= LARGEST).all())
    if within:
        return array
    if not np.isfinite(array).all():
        raise InvalidInput(f"{_first(what, array, ~np.isfinite(array))} must be finite")
    raise InvalidInput(f"{_first(what, array, np.abs(array) > LARGEST)} must be at most {LARGEST:g} in size")


def positive(value: ArrayLike, what: str, *, unit: str = "") -> Array:
    """`value` as an array of positive numbers from `LEAST` to `LARGEST`."""
    array = numbers(value, what)
    if array.ndim == 0 and LEAST <= array.item() <= LARGEST:
        return array
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
    if array.ndim == 0 and 0.0 <= array.item() <= LARGEST:
        return array
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
    """`value`, which must be callable."""
    if callable(value):
        return value
    raise InvalidInput(f"{what} = {brief(value)} is a {type(value).__name__}; it must be a function")


def per_row(value: Array, rows: int, what: str, of: str = "row") -> Array:
    """`value` for each of `rows` rows; a scalar is used for all of them."""
    if value.ndim == 0:
        return np.full(rows, float(value))
    if value.shape != (rows,):
        raise InvalidInput(f"{what} has shape {value.shape}; it must be one number, or ({rows},): one a {of}")
    return value


def per_joint(value: ArrayLike, joints: int, what: str, *, unit: str, zero_holds: bool = False) -> Array:
    """`value` for each joint: positive, or 0 if `zero_holds`; an array may be infinite for a joint without limit."""
    return np.array(per_row(limits(value, what, unit=unit, zero_holds=zero_holds), joints, what, "joint"))


def limits(value: ArrayLike, what: str, *, unit: str, zero_holds: bool = False) -> Array:
    """`value` as positive numbers, or 0 if `zero_holds`; an array may be infinite for a joint without limit."""
    array = numbers(value, what)
    free = (array == np.inf) & (array.ndim > 0)
    checked = not_negative if zero_holds else positive
    if not free.any():
        return checked(array, what, unit=unit)
    return np.where(free, np.inf, checked(np.where(free, 1.0, array), what, unit=unit))


def pair(value: tuple[T, T], what: str, of: str) -> tuple[T, T]:
    """`value`, which must be a tuple, a list or an array of two entries, as a tuple."""
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
    """Lowest and highest positions of the joints, shape (2, rows); no lowest is above its highest.

    Parameters
    ----------
    value : pair of float or array, shape (rows,)
        A number holds for every joint that has a position; arrays must be infinite for joints that have none.
    rows : int
    what : str
        Name of the argument in messages.
    has : array of bool, shape (rows,), optional
        Which joints have a position (default: all).
    units, names : sequence of str, optional
        Unit and name of each joint, for messages.

    Raises
    ------
    InvalidInput
        The message names the joint, its value, and what is allowed.
    """
    lowest, highest = pair(value, what, "lowest and highest [rad], [m]")
    has = np.ones(rows, dtype=np.bool_) if has is None else has
    ends = []
    for given, name, free in (lowest, "lowest", -np.inf), (highest, "highest", np.inf):
        own = numbers(given, f"{what}, {name}")
        spread = per_row(own, rows, f"{what}, {name}", "joint")
        ends.append(np.where(has, spread, free) if own.ndim == 0 else np.array(spread))
    low, high = both = np.array(ends) + 0.0  # turns -0 into 0
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
    return both


def suggestion(name: str, names: Iterable[str]) -> str:
    """End of the error message for an unknown name: similar names, or all names if they are few."""
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
