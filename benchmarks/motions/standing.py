"""Recorded ticks of robots that stand, as hierarchies of accelerations and contact forces; one with torques besides."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from hqp import Hierarchy, Level, Side, Solver

from ..standing.scenes import DT, StandingScene, declare
from ..standing.scenes import SCENES as STANDING
from ..standing.stream import record, restore
from .data import DRAWS, Ticks, ticks
from .playback import Played

#: Ticks of a scene from one that is kept to the next, where no contact changes.
EVERY = 25
#: By the name of their family; the humanoid and the quadruped that the library has the data of.
SCENES: dict[str, StandingScene] = {s.name: s for s in STANDING if s.body.robot in ("g1", "go2")}
#: The family whose unknowns are accelerations, forces and torques, of these ticks.
WITH_TORQUES = "go2 with torques"
OF_TORQUES = "go2 steps"
#: Of the hierarchies of a scene: bounds of forces, motion equation and contacts, limits; then tasks.
_FORCES, _MOTION, _LIMITS = range(3)


class Standing(Played):
    """Recorded ticks of a scene.

    Parameters
    ----------
    scene : StandingScene
    recorded : dict of str to array, shape (draws, 2, ...)
        ``q``, ``v``, the time ``t``, and ``contacts/FOOT``: how the contact of each foot is.
    """

    def __init__(self, scene: StandingScene, recorded: Ticks) -> None:
        robot = scene.load()
        self.declared = declare(scene, robot)
        super().__init__(robot, self.declared.stack, "acceleration", DT, {k: recorded[k] for k in ("q", "v", "t")})
        self.contacts = {foot: recorded[f"contacts/{foot}"] for foot in scene.body.feet}
        self.recorded = recorded

    def _hierarchy(self, draw: int, tick: int) -> Hierarchy:
        numbers = {foot: rows[draw, tick] for foot, rows in self.contacts.items()}
        restore(self.declared.contacts, self.rows.shared, numbers)
        return super()._hierarchy(draw, tick)


class WithTorques(Standing):
    r"""The same with the torques as unknowns, in three levels, as a well known controller of legged robots has them.

    x = (a, f, tau), and first of all, on one level, :math:`M a + b = S^T \tau + G^T f`, contacts, torques within their
    limits and forces within their cones; then the base and the lifted foot; then least forces.
    """

    def _hierarchy(self, draw: int, tick: int) -> Hierarchy:
        return with_torques(super()._hierarchy(draw, tick), self.robot.nv, len(self._torques()))

    def _torques(self) -> NDArray[np.intp]:
        return np.flatnonzero(np.isfinite(self.robot.torque_limit))


def with_torques(problem: Hierarchy, nv: int, joints: int) -> Hierarchy:
    """Accelerations and forces, and the torques of so many joints besides, which the first limits are of."""
    n, forces = problem.n + joints, problem.n - nv

    def wide(A: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.hstack([A, np.zeros((len(A), joints))])

    motion, limits = problem.levels[_MOTION], problem.levels[_LIMITS]
    assert motion.A is not None
    assert limits.A is not None
    rows, cones = limits.A[:joints], limits.A[joints + nv :]
    middle, most = (0.5 * (limits.upper[:joints] + sign * limits.lower[:joints]) for sign in (1.0, -1.0))
    own = np.eye(n)
    above = Level(
        np.vstack(
            [wide(problem.matrix(_FORCES)), wide(motion.A), wide(rows) - own[-joints:], own[-joints:], wide(cones)]
        ),
        np.concatenate([problem.levels[_FORCES].lower, motion.lower, middle, -most, limits.lower[joints + nv :]]),
        np.concatenate([problem.levels[_FORCES].upper, motion.upper, middle, most, limits.upper[joints + nv :]]),
    )
    tasks = range(_LIMITS + 1, len(problem.levels) - 1)
    A = np.vstack([wide(problem.matrix(k)) for k in tasks])
    base = Level.equality(A, np.concatenate([problem.levels[k].lower for k in tasks]))
    least = Level.bounds(np.zeros(forces), np.zeros(forces), indices=np.arange(nv, nv + forces))
    return Hierarchy([above, base, least])


def record_standing(scene: StandingScene, draws: int = DRAWS) -> Ticks:
    """The ticks that are kept of a scene, evenly spread: of those at which a contact changes, where any does.

    The tick before belongs to them, so that none at which the robot has just been set back on its feet is kept.
    """
    stream = record(scene, draws * EVERY)
    follows = (stream.v != 0.0).any(axis=1)
    changing = np.flatnonzero(stream.changing & follows)
    among = changing if len(changing) >= draws else np.flatnonzero(follows)
    now = among[np.linspace(0, len(among) - 1, draws).round().astype(int)]
    at = np.column_stack([now - 1, now])
    contacts = {f"contacts/{foot}": rows[at] for foot, rows in stream.contacts.items()}
    return {"q": stream.q[at], "v": stream.v[at], "t": DT * at, **contacts}


def file_of(scene: StandingScene) -> str:
    """Of its robot, for what stands."""
    return f"{scene.body.robot}-contacts"


def families() -> dict[str, tuple[StandingScene, type[Standing]]]:
    """Name -> the scene whose ticks it has, and what makes hierarchies of them."""
    return {name: (scene, Standing) for name, scene in SCENES.items()} | {
        WITH_TORQUES: (SCENES[OF_TORQUES], WithTorques)
    }


def pressed(problem: Hierarchy) -> int:
    """How many rows that are no equalities are at a bound at the answer, of all levels."""
    solution = Solver().solve(problem)
    unequal = [level.lower < level.upper for level in problem.levels]
    return sum(
        int(np.count_nonzero((told.active != Side.INACTIVE) & own))
        for told, own in zip(solution.levels, unequal, strict=True)
    )


@cache
def standing(name: str) -> Standing:
    """The family of this name of the group "contacts", built once a process."""
    scene, kind = families()[name]
    return kind(scene, ticks(file_of(scene), scene.name))
