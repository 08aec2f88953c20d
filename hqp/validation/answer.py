"""A hierarchy whose solution is known, and its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..backends.registry import BackendInfo
from ..hierarchy import Hierarchy


@dataclass(frozen=True, eq=False, kw_only=True)
class KnownAnswer:
    """A hierarchy and its known solution.

    Attributes
    ----------
    name : str
    source : str
        The source of the numbers.
    why : str
        How they follow.
    hierarchy : Hierarchy
    x : array, shape (n,)
    residuals : array, shape (levels,)
        Weighted norms.
    multipliers : mapping of int to array
        For the levels whose multipliers are known and unique: one number for every row above.
    unique : bool
        Whether the levels alone make x unique, or only the implicit last one does.
    stack : Hierarchy, optional
        The stack for which Eq. 4.8 has this answer.
    x_ref : array, shape (n,), optional
        Of the implicit last level ``min ||x - x_ref||`` (default: zero).
    """

    name: str
    source: str
    why: str
    hierarchy: Hierarchy
    x: Array
    residuals: Array
    multipliers: Mapping[int, Array] = field(default_factory=dict)
    unique: bool = True
    stack: Hierarchy | None = None
    x_ref: Array | None = None

    def posed_to(self, info: BackendInfo) -> Hierarchy | None:
        """The hierarchy given to the backend, or None if the backend does not take it."""
        if not info.lexicographic:
            return self.stack
        equalities = bool(np.all(self.hierarchy.lower == self.hierarchy.upper))
        return self.hierarchy if equalities or info.inequalities else None
