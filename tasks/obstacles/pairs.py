"""All pairs of a link and an obstacle, and their distances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hqp import InvalidInput
from hqp.checks import listed
from hqp.errors import brief

from ..base.checks import Array
from ..base.live import Live, structure
from ..base.telling import tell
from ..robots.robot import Robot, RobotState, at_rest
from .links import LinkCapsule
from .shapes import Obstacle


class Pairs(Live):
    """Every pair of a link and an obstacle, the obstacles of the first link first.

    Parameters
    ----------
    links : sequence of LinkCapsule
    obstacles : sequence of Obstacle
    what : str
        Name of the part in messages.

    Raises
    ------
    InvalidInput
        If an entry is not a link or an obstacle, or there is none.
    """

    links: tuple[LinkCapsule, ...] = structure()
    obstacles: tuple[Obstacle, ...] = structure()

    def __init__(self, links: Sequence[LinkCapsule], obstacles: Sequence[Obstacle], what: str) -> None:
        self._what = what
        self.links = tuple(listed(links, f"{what}: links", "LinkCapsule"))
        self.obstacles = tuple(listed(obstacles, f"{what}: obstacles", "Sphere and Capsule"))
        for kind, given in (LinkCapsule, self.links), (Obstacle, self.obstacles):
            wrong = [value for value in given if not isinstance(value, kind)]
            if wrong or not given:
                got = brief(wrong[0]) if wrong else "none"
                raise InvalidInput(f"{what}: got {got}; it takes at least one {kind.__name__} in a list")
        self._bound: tuple[Robot, list[Array]] | None = None

    def __len__(self) -> int:
        return len(self.links) * len(self.obstacles)

    def names(self) -> list[str]:
        """One a pair: ``"link 2 - obstacle 1"``."""
        return [f"{link.name} - obstacle {j + 1}" for link in self.links for j in range(len(self.obstacles))]

    def bind(self, robot: Robot) -> list[Array]:
        """Where the links begin and end, in the coordinates of their frames; refuses frames the robot does not have.

        It depends only on structure, which does not change, and is computed once per robot.
        """
        bound = self._bound
        if bound is None or bound[0] is not robot:
            try:
                bound = self._bound = robot, [link.bind(robot) for link in self.links]
            except InvalidInput as refusal:
                raise InvalidInput(f"{self._what}: {refusal}") from None
            self._tell_of_flat(robot)
        return bound[1]

    def _tell_of_flat(self, robot: Robot) -> None:
        """Tell of obstacles with two numbers beside a robot in space: they lie on the floor."""
        flat = [brief(obstacle) for obstacle in self.obstacles if obstacle.is_flat]
        if flat and at_rest(robot).frame(self.links[0].frame).rotation.ndim == 2:
            tell(f"{self._what}: obstacles of two numbers are at z = 0: {', '.join(flat)}")

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_bound": None}

    def measure(self, robot: Robot, state: RobotState, t: float = 0.0) -> Array:
        """Distance, normal and witness of every pair at time t [s], shape (pairs, 7) [m].

        The distance is that of the surfaces, negative where they overlap; the unit normal points from the obstacle to
        the link, and the witness is the point of the link's core that is nearest.
        """
        from ..base.loops import Call
        from ..robots.block import fill
        from ..robots.kernels.block import size
        from .kernels.distances import measure_pairs
        from .pair_arrays import PairArrays

        def block(frame: str) -> Array:
            own = np.zeros(size(robot.nv))
            fill(own, state.frame(frame), state.v, drifts=False)
            return own

        arrays = PairArrays(self, robot, block, t)
        Call(measure_pairs, arrays.table).run()
        return arrays.found
