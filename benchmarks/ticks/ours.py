"""Driver of this library."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from hqp import DampingRule, Solver, certify
from hqp.arrays import Array
from tasks import CenterOfMassTask, Controller, Step

from .driver import Driver
from .stack import declare
from .stream import Stream

#: What a controller is told by who wants no damping beside that of the levels; others say nothing.
STRICT: Mapping[str, Any] = {"damping": None}


class Ours(Driver):
    """A :class:`tasks.Controller`, called as a user would.

    Parameters
    ----------
    stream : Stream
    name : str
    damping : dict
        Rules for the levels that begin with a goal of this kind; others are strict.
    acceleration : float, optional
        What the joints keep, too [rad/s^2].
    strict : bool
        Whether only those levels are damped that have a rule; else the default damping is left on.
    """

    def __init__(
        self,
        stream: Stream,
        *,
        name: str = "hqp",
        damping: Mapping[str, DampingRule | float] = MappingProxyType({}),
        acceleration: float | None = None,
        strict: bool = True,
    ) -> None:
        super().__init__(name, stream)
        scene, self.robot = stream.scene, stream.scene.load()
        if acceleration is not None:
            self.robot.acceleration_limit = np.full(self.robot.nv, acceleration)
        self.stack, targets = declare(scene, self.robot, damping)
        self.controller = Controller(self.robot, self.stack, dt=scene.dt, **(STRICT if strict else {}))
        self.q, self.v = list(stream.q), list(stream.v)
        self.targets = [(target, list(stream.positions[name])) for name, target in targets.positions.items()]
        self.targets += [(target, list(stream.rotations[name])) for name, target in targets.rotations.items()]
        # The parts alone, warm on their own.
        self.rows, self.solver = self.stack.build(self.robot, "velocity", scene.dt), Solver()
        self.weighs = any(isinstance(part, CenterOfMassTask) for part in self.stack)

    def stand(self, k: int, q: Array, v: Array) -> None:
        self.q[k], self.v[k] = q, v

    def tick(self, k: int) -> Step:
        self.aim(k)
        return self.controller(self.q[k], self.v[k], 0.0)

    def stages(self, k: int) -> Iterator[None]:
        state = self.robot.at(self.q[k], self.v[k])
        if self.weighs:
            self.robot.compute_center_of_mass(state.q)
        state.ready()
        yield
        self.aim(k)
        hierarchy = self.rows.fill(state, 0.0)
        yield
        self.solver.solve(hierarchy)
        yield

    def aim(self, k: int) -> None:
        """Set all targets."""
        for target, values in self.targets:
            target.move(values[k])

    def velocity(self, answer: Step) -> Array:
        assert answer.v is not None
        return answer.v if answer.ok else np.full_like(answer.v, np.nan)

    def proved(self, k: int, v: Array) -> bool:
        self.aim(k)
        return certify(self.rows.fill(self.robot.at(self.q[k], self.v[k]), 0.0), v).ok
