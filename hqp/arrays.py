"""The arrays that everything here is made of, and how input becomes one."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidInput

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


def real_array(value: ArrayLike, what: str) -> Array:
    """A float array of its own from whatever holds real numbers, or InvalidInput that names `what`."""
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{what} is not an array of real numbers ({error})") from None


def finite_vector(value: ArrayLike, n: int, what: str) -> Array:
    """A finite float vector of length n, or InvalidInput that says what is wrong."""
    vector = real_array(value, what)
    if vector.shape != (n,):
        raise InvalidInput(f"{what} has shape {vector.shape}; it must be ({n},)")
    if not np.isfinite(vector).all():
        index = int(np.argmin(np.isfinite(vector)))
        raise InvalidInput(f"{what}[{index}] = {vector[index]} must be finite")
    return vector
