"""Refusals that the whole package shares: each names the thing, its value, and what is allowed."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hqp import InvalidInput

Array = NDArray[np.float64]


def numbers(value: ArrayLike, what: str) -> Array:
    """`value` as a float array of its own (read-only), or InvalidInput."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{what} is not an array of real numbers ({error})") from None
    array.flags.writeable = False
    return array


def finite(value: ArrayLike, what: str) -> Array:
    """`value` as an array of finite numbers."""
    array = numbers(value, what)
    if not np.isfinite(array).all():
        raise InvalidInput(f"{_first(what, array, ~np.isfinite(array))} must be finite")
    return array


def positive(value: ArrayLike, what: str, *, unit: str = "") -> Array:
    """`value` as an array of positive finite numbers."""
    array = numbers(value, what)
    wrong = ~((array > 0) & np.isfinite(array))
    if wrong.any():
        raise InvalidInput(f"{_first(what, array, wrong)}{unit and ' ' + unit} must be positive and finite")
    return array


def positive_scalar(value: float, what: str, *, unit: str = "") -> float:
    """`value` as one positive finite number."""
    array = positive(value, what, unit=unit)
    if array.ndim:
        raise InvalidInput(f"{what} has shape {array.shape}; it must be one number")
    return float(array)


def per_row(value: Array, rows: int, what: str, of: str = "row") -> Array:
    """`value` for each of so many rows: a scalar stands for all of them."""
    if value.ndim == 0:
        return np.full(rows, float(value))
    if value.shape != (rows,):
        raise InvalidInput(f"{what} has shape {value.shape}; it must be one number, or ({rows},): one a {of}")
    return value


def _first(what: str, array: Array, wrong: NDArray[np.bool_]) -> str:
    """The first wrong entry, named by its place: ``task 'hand': gain, row 1 = -2.0``."""
    if array.ndim == 0:
        return f"{what} = {array}"
    place = tuple(int(i) for i in np.argwhere(wrong)[0])
    return f"{what}[{', '.join(map(str, place))}] = {array[place]}"
