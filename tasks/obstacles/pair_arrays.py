"""Links and obstacles as arrays for the compiled loops; moving ones are written anew every tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array, fill
from ..base.once import once
from ..robots.robot import Robot
from .links import LinkCapsule
from .shapes import Obstacle

if TYPE_CHECKING:
    from ..rows.site import Move


class Paired(Protocol):
    """Links and obstacles, see :class:`tasks.obstacles.pairs.Pairs`."""

    links: tuple[LinkCapsule, ...]
    obstacles: tuple[Obstacle, ...]

    def __len__(self) -> int: ...

    def bind(self, robot: Robot) -> list[Array]: ...


class PairArrays:
    """The pairs of links and obstacles of one robot, in arrays for the loops.

    Parameters
    ----------
    pairs : Pairs
    robot : Robot
    block : callable
        Gives the block of a frame.
    t : float
        Time at which the obstacles are evaluated [s].
    dt : float, optional
        Tick [s], if the displacement of the obstacles in the next tick is needed.
    rates : bool
        Whether their velocities and accelerations are needed.

    Attributes
    ----------
    table : Table
        Arguments of :mod:`tasks.obstacles.kernels.distances`.
    found : array, shape (pairs, 7)
        Distance, normal and witness of each pair.
    moves : tuple of callable
        Functions of time [s] that update the obstacles.
    """

    def __init__(
        self,
        pairs: Paired,
        robot: Robot,
        block: Callable[[str], Array],
        t: float = 0.0,
        *,
        dt: float | None = None,
        rates: bool = False,
    ) -> None:
        from ..base.loops import Table
        from .kernels import distances as of

        blocks = Table(*(block(link.frame) for link in pairs.links))
        ends = zip(pairs.bind(robot), pairs.links, strict=True)
        capsules = np.array([[*segment.ravel(), link.radius] for segment, link in ends])
        shapes, work = np.zeros((len(pairs.obstacles), of.SHAPE)), np.zeros(21)
        self.found = np.zeros((len(pairs), of.PAIR))
        followed = [_follow(*own, dt, rates) for own in zip(pairs.obstacles, shapes, strict=True)]
        for move in followed:
            move(t)
        self.moves: tuple[Move, ...] = tuple(
            move for move, obstacle in zip(followed, pairs.obstacles, strict=True) if not _stands(obstacle)
        )
        self.table = Table(len(pairs.links), len(pairs.obstacles), blocks, capsules, shapes, self.found, work)


def _follow(obstacle: Obstacle, shape: Array, dt: float | None, rates: bool) -> Move:
    """The function of time that writes an obstacle into its array."""
    from .kernels import distances as of

    core = shape[of.CORE : of.VELOCITY].reshape(2, 3)
    shift, velocity = shape[of.SHIFT : of.SHAPE], shape[of.VELOCITY : of.ACCELERATION]
    acceleration = shape[of.ACCELERATION : of.SHIFT]
    what = [f"{obstacle.full_name()}: {rate}(t)" for rate in ("velocity", "acceleration")]

    def move(t: float) -> None:
        points = np.asarray(obstacle.core(t))
        if points.shape not in {(1, 3), (2, 3)}:
            raise InvalidInput(
                f"{obstacle.full_name()}: core({t:g}) has shape {points.shape}; it must be (1, 3) or (2, 3)"
            )
        shape[of.RADIUS], core[:] = obstacle.radius, points  # one point stands for both ends
        if dt is not None:
            with np.errstate(invalid="ignore", over="ignore"):  # the solver tells of it
                shift[:] = obstacle.core(t + dt)[0] - points[0]
        if rates:
            fill(velocity, obstacle.velocity(t), what[0])
            fill(acceleration, obstacle.acceleration(t), what[1])

    return move


def _stands(obstacle: Obstacle) -> bool:
    return not (_asked(type(obstacle)) or obstacle.moves)


@once
def _asked(kind: type) -> bool:
    """Whether a user's class defines its place but not `moves`: it is then evaluated at every tick."""
    for cls in kind.__mro__:
        if "moves" in vars(cls):
            return False
        if any(name in vars(cls) for name in ("core", "velocity", "acceleration", "radius")):
            return True
    raise AssertionError(kind)
