"""What damped levels are damped towards: at acceleration order they brake, as fast as their tasks decay."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import Array
from .components import Components, Work

if TYPE_CHECKING:
    from ..base.loops import Call
    from .site import Workspace


class Aims:
    """The aims of the levels of a stack, kept up to date by a loop.

    Parameters
    ----------
    levels, n, nv : int
        How many levels, unknowns and joint velocities there are.
    components : Components
        Joints that move independently of each other.

    Attributes
    ----------
    every : array, shape (levels, n)
        Of each level ``-2 zeta K v`` by the fastest of its tasks, and the forces that bear the robot at rest; zero for
        those that are not damped.
    rates : array, shape (levels, nv)
        How fast the fastest of the tasks of a level that move a joint decays [1/s].
    damped : tuple of int
        The levels that are damped, where aims are not zero: at acceleration order.
    """

    def __init__(self, levels: int, n: int, nv: int, components: Components) -> None:
        self.every, self.rates = np.zeros((levels, n)), np.zeros((levels, nv))
        self.damped: tuple[int, ...] = ()
        self.components = components

    @property
    def by_level(self) -> Mapping[int | str, Array] | None:
        """Those of the damped levels; None where no level is."""
        return {k: self.every[k] for k in self.damped} or None

    def take_rates(self, work: Iterable[Work]) -> None:
        """Take how fast tasks decay: every joint by those that have rows in its component."""
        self.rates[:] = 0.0
        for level, row, part, _, site in work:
            touched, rates = self.components.touched(row, site.rows), self.rates[level]
            rates[touched] = np.maximum(rates[touched], part.decay_rate())

    def calls(self, shared: Workspace) -> Sequence[Call]:
        """What keeps them up to date."""
        if not self.damped:
            return ()
        from ..base.loops import Call
        from .kernels.braking import write_damping

        aims = ((self.rates[k], self.every[k]) for k in self.damped)
        return [Call(write_damping, shared.n, rates, shared.v, aim, aim) for rates, aim in aims]
