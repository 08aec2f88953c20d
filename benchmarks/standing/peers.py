"""Other drivers for a robot that stands, with the rows of this library: weighted QPs, and DAQP's hierarchy."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from hqp import Hierarchy
from hqp.arrays import Array
from hqp.backends.daqp import DaqpProblem
from tasks.control.torques import ContactTorques

from ..methods.daqp_direct import TOLERANCES
from .ours import Standing
from .solvers import NoAnswer, QPSolver
from .stream import StandingStream
from .weighted import Weighing

if TYPE_CHECKING:
    from tasks.robots.pinocchio_state import PinocchioState

#: What a tick ends with: the answer, and the joint torques.
Answer = tuple[Array, Array]


class Peer(Standing):
    """A driver that solves the rows of this library by another solver, and computes the torques."""

    def __init__(self, name: str, stream: StandingStream) -> None:
        super().__init__(name, stream)
        self.torques = ContactTorques()

    def tick(self, k: int) -> Answer:
        state = self.state(k)
        *_, x = self._parts(k, state)
        assert x is not None
        tau = self.torques(self.rows, state, x, valid=True)
        assert tau is not None  # the states are finite
        return x, tau

    def stages(self, k: int) -> Iterator[None]:
        yield from (None for _ in self._parts(k, self.state(k)))

    def velocity(self, answer: Answer) -> Array:
        return answer[0]

    def _parts(self, k: int, state: PinocchioState) -> Iterator[Array | None]:
        """Kinematics, rows, solve; the last gives the answer."""
        state.accelerated()
        yield None
        yield from self._decide(self.fill(k, state))

    def _decide(self, hierarchy: Hierarchy) -> Iterator[Array | None]:
        """What is left of rows, laid out as the solver takes them, and the answer."""
        raise NotImplementedError


class Weighted(Peer):
    """One weighted QP a tick."""

    def __init__(self, solver: QPSolver, stream: StandingStream) -> None:
        super().__init__(f"weighted {solver.name}", stream)
        self.solver, self.weighing = solver, Weighing(self.rows, self.hard)

    def _decide(self, hierarchy: Hierarchy) -> Iterator[Array | None]:
        given = self.solver.given(self.weighing.qp())
        yield None
        yield self.solver.solve(given)


class DaqpStanding(Peer):
    """DAQP's own hierarchy, cold: it takes its first level for hard."""

    def __init__(self, stream: StandingStream) -> None:
        super().__init__("daqp hierarchy", stream)
        self.call, self.H, self.f = import_module("daqp").solve, np.eye(self.unknowns), np.zeros(self.unknowns)

    def _decide(self, hierarchy: Hierarchy) -> Iterator[Array | None]:
        rows = DaqpProblem.of(hierarchy)
        yield None
        x, _, flag, _ = self.call(
            self.H, self.f, rows.A, rows.upper, rows.lower, rows.sense, rows.break_points, **TOLERANCES
        )
        if flag <= 0:
            raise NoAnswer(f"exit flag {flag}")
        yield np.asarray(x)
