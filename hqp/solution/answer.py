"""The interface that stages of damped levels need of the solutions of plain hierarchies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from ..arrays import Array
from ..certificate import Certificate, Explanation
from ..hierarchy import Hierarchy
from ..settings import Settings
from .level import LevelSolution


class Answer(Protocol):
    """The answer to one hierarchy, its proof and its explanation; see :class:`hqp.Solution`."""

    @property
    def x(self) -> Array: ...

    @property
    def x_ref(self) -> Array: ...

    @property
    def hierarchy(self) -> Hierarchy: ...

    @property
    def ok(self) -> bool: ...

    @property
    def settings(self) -> Settings: ...

    @property
    def message(self) -> str: ...

    @property
    def levels(self) -> tuple[LevelSolution, ...]: ...

    @property
    def stages(self) -> Sequence[Answer]: ...

    def certify(self, *, unique: bool = True, tolerance: float = 1e-9) -> Certificate: ...

    def explain(self, *, tolerance: float = 1e-9) -> Explanation: ...
