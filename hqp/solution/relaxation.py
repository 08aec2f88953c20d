"""The damped levels of a solution: the damping used, and how much residual it cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from ..arrays import Array
from .softening import Softened


@dataclass(frozen=True, eq=False)
class Relaxation:
    """One damped level: its damping, and the residual that this costs.

    Attributes
    ----------
    level, name
        Index and name in the hierarchy.
    damping : float
        The lambda that the rule chose, the largest where it is not the same in all directions; 0 where the level was
        left strict.
    aim : array, shape (n,)
        What it is damped towards.
    residual_norm : float
        ``||D_k w_k||`` at the solution.
    moved : float
        How far the levels below moved the rows of this one from the values that it reached, ``||D_k A_k (x - x_k)||``.
    """

    level: int
    name: str
    damping: float
    aim: Array = field(repr=False)
    residual_norm: float
    moved: float = field(repr=False)
    _strict: Callable[[], float] = field(repr=False)
    _softened: Callable[[], tuple[Softened, ...]] = field(repr=False)

    @cached_property
    def strict_norm(self) -> float:
        """The residual norm without the damping of this level, below what those above reached; solved when first read.

        Under the default damping of a controller also without what pulls it to the last velocities.
        """
        return self._strict()

    @cached_property
    def softened(self) -> tuple[Softened, ...]:
        """The directions in which the level was softened, the weakest first, with the share of the target met there."""
        return self._softened()

    @property
    def excess(self) -> float:
        """The increase of the residual norm that the damping costs."""
        return self.residual_norm - self.strict_norm
