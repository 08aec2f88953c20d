"""This library."""

from __future__ import annotations

from collections.abc import Iterator

from hqp import Solver, certify
from hqp.arrays import Array
from tasks import CenterOfMassTask, Controller, Step

from .driver import Driver
from .stack import declare
from .stream import Stream


class Ours(Driver):
    """A :class:`tasks.Controller`, called as a user would."""

    def __init__(self, stream: Stream) -> None:
        super().__init__("hqp", stream)
        scene, self.robot = stream.scene, stream.scene.load()
        self.stack, targets = declare(scene, self.robot)
        self.controller = Controller(self.robot, self.stack, dt=scene.dt)
        self.q, self.v = list(stream.q), list(stream.v)
        self.targets = [(target, list(stream.positions[name])) for name, target in targets.positions.items()]
        self.targets += [(target, list(stream.rotations[name])) for name, target in targets.rotations.items()]
        # The parts alone, warm on their own.
        self.rows, self.solver = self.stack.build(self.robot, "velocity", scene.dt), Solver()
        self.weighs = any(isinstance(part, CenterOfMassTask) for part in self.stack)

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
        return answer.v

    def proved(self, k: int, v: Array) -> bool:
        self.aim(k)
        return certify(self.rows.fill(self.robot.at(self.q[k], self.v[k]), 0.0), v).ok
