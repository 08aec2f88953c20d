"""Links and obstacles, pair by pair: how far apart, where, and how that follows the joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hqp import InvalidInput
from hqp.checks import listed
from hqp.errors import brief

from .._checks import Array
from ..robots.robot import Robot, RobotState
from .links import LinkCapsule, Placed, axes
from .shapes import TOUCHING, Obstacle, nearest_points


@dataclass(frozen=True, slots=True)
class Distance:
    """One pair at one instant.

    Attributes
    ----------
    distance : float
        Of the surfaces [m]; negative where they overlap.
    normal : array, shape (3,)
        Unit vector from the obstacle to the link.
    witness, other : array, shape (3,)
        The points of both cores that are nearest [m].
    place : Placed
        The witness, carried by its link.
    core : array, shape (k, 3)
        The points of the obstacle's core [m].
    """

    distance: float
    normal: Array
    witness: Array
    other: Array
    place: Placed
    core: Array

    @property
    def gradient(self) -> Array:
        """How the distance follows the joints while the obstacle stands still, n^T J, shape (nv,)."""
        return np.asarray(self.normal @ self.place.jacobian)


class Pairs:
    """Every link against every obstacle, the obstacles of the first link first.

    Parameters
    ----------
    links : sequence of LinkCapsule
    obstacles : sequence of Obstacle
    what : str
        How messages call who asks.

    Raises
    ------
    InvalidInput
        If one of them is no link or no obstacle, or there is none.
    """

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
        """Where the links end, in the coordinates of their frames; refuses what the robot has not."""
        bound = self._bound
        if bound is None or bound[0] is not robot:
            try:
                bound = self._bound = robot, [link.bind(robot) for link in self.links]
            except InvalidInput as refusal:
                raise InvalidInput(f"{self._what}: {refusal}") from None
        return bound[1]

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_bound": None}

    def at(self, state: RobotState, ends: list[Array], t: float) -> list[Distance]:
        """All pairs in this state, at time t [s]."""
        cores = [obstacle.core(t) for obstacle in self.obstacles]
        found = []
        for link, end in zip(self.links, ends, strict=True):
            frame = state.frame(link.frame)
            segment = np.array([frame.position, frame.position + axes(frame) @ end])
            for obstacle, core in zip(self.obstacles, cores, strict=True):
                witness, other = nearest_points(segment, core)
                gap = witness - other
                D = float(np.sqrt(gap @ gap))
                # Where the cores cross no direction leads out; from middle to middle is as good as any.
                way = gap if D > TOUCHING else segment.mean(axis=0) - core.mean(axis=0)
                size = float(np.sqrt(way @ way))
                normal = way / size if size > TOUCHING else np.array([1.0, 0.0, 0.0])
                place = Placed(frame, witness)
                found.append(Distance(D - link.radius - obstacle.radius, normal, witness, other, place, core))
        return found
