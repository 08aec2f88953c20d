"""Conversion of input to float and integer arrays; a refusal names the argument and what is wrong with it."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidInput, brief

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
#: Integers up to this one are floats without rounding.
EXACT = 2**53


def real_array(value: ArrayLike, what: str) -> Array:
    """A new float array from any object that holds real numbers, or InvalidInput that names `what`.

    Strings, dates, None, masked entries and imaginary parts are refused, not converted.
    """
    if type(value) is np.ndarray and value.dtype == np.float64:  # as it mostly is in a control loop
        return value.copy()
    if type(value) is float or (type(value) is int and -EXACT <= value <= EXACT):
        return np.array(float(value))
    refusal = f"{what} is not an array of real numbers"
    given = _as_array(value, refusal)
    strangers: list[Any] = [] if given.dtype.kind in "biuf" else [value]
    if given.dtype.kind == "O":
        strangers = [item for item in given.flat if not isinstance(item, Real)]
    if strangers:
        raise InvalidInput(f"{refusal} (it holds {brief(strangers[0])})")
    return np.array(_as_array(given, refusal, np.float64))


def _as_array(value: Any, refusal: str, dtype: type[np.float64] | None = None) -> NDArray[Any]:
    """What numpy makes of `value`, or InvalidInput: no rectangle, a masked entry, an integer beyond all floats."""
    if np.ma.is_masked(value):
        raise InvalidInput(f"{refusal} (it has masked entries)")
    try:
        with np.errstate(over="ignore"):
            return np.asarray(value, dtype)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"{refusal} ({error})") from None


def index_vector(value: ArrayLike, what: str) -> Indices:
    """One axis of integers, or InvalidInput that names `what`."""
    given = _as_array(value, f"{what} must be one axis of integers")
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
        raise InvalidInput(f"{what} must be one axis of integers, not {given.dtype} of shape {given.shape}")
    return given.astype(np.intp)


def finite_vector(value: ArrayLike, n: int, what: str) -> Array:
    """A finite float vector of length n, or InvalidInput that says what is wrong."""
    vector = real_array(value, what)
    if vector.shape != (n,):
        raise InvalidInput(f"{what} has shape {vector.shape}; it must be ({n},)")
    if not np.isfinite(vector).all():
        index = int(np.argmin(np.isfinite(vector)))
        raise InvalidInput(f"{what}[{index}] = {vector[index]} must be finite")
    return vector


def length(vector: Array) -> float:
    """Euclidean norm."""
    return math.sqrt(vector @ vector)


def lengths(rows: Array) -> Array:
    """Euclidean norm of each row."""
    norms: Array = np.sqrt((rows * rows).sum(axis=1))
    return norms


def products(rows: Array, x: Array) -> Array:
    """The product of each row (m, n) with x (n,), exact but for one rounding.

    Of each entry and its factor, split in two of half the digits (Veltkamp 1968), all four products are exact.
    """
    factors, parts = (_halves(rows), _halves(x))
    terms = np.concatenate([a * b for a in factors for b in parts], axis=1)
    return np.array([math.fsum(row) for row in terms.tolist()])


def _halves(numbers: Array) -> tuple[Array, Array]:
    """Two arrays of numbers of 26 digits each, whose sum are these."""
    above = (2.0**27 + 1.0) * numbers
    high = above - (above - numbers)
    return high, numbers - high
