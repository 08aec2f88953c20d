"""Disturbance of the first level by lower ones: five stacks for arms, in this library and in others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from hqp import Hierarchy, Solution, Solver, certify
from hqp.arrays import Array

from .tables import Row
from .teleoperation.scenes import KNOWN
from .teleoperation.setups import Elsewhere, Own, Peer
from .ticks.ours import Ours
from .ticks.scenes import SCENES, Scene
from .ticks.stream import Stream, record

#: Limits > position > orientation > posture in all of them; what differs is the arm, its speed and where it is led.
STACKS: tuple[Scene, ...] = (
    *SCENES[:2],
    *(scene for scene in KNOWN if scene.name in {"stretched", "slow joints", "ur5 stretched"}),
)
#: States of each stack; of how many ticks they are taken; and what counts as a loss [m/s].
STATES, TICKS, LOSS = 80, 1000, 1e-3
#: This library, then weights, weights that are nearly priorities, and priorities by projection.
METHODS: tuple[Own | Peer | Elsewhere, ...] = (
    Own("hqp strict"),
    Own("hqp", {"strict": False}),
    Peer("pink", "daqp"),
    Peer("pink", "daqp", "lm 100", lm=1.0, first=100.0, options={"safety_break": False}),
    Peer("mink", "daqp"),
    Peer("roboplan", ""),
    Peer("roboplan", "", "levels", options={"priorities": True}),
    Peer("roboplan", "", "levels 1e-10", options={"priorities": True, "tolerance": 1e-10}),
    Elsewhere("placo"),
    Elsewhere("placo", "scaled", {"first": "scaled"}),
    Elsewhere("placo", "hard", {"first": "hard"}),
    Elsewhere("tsid"),
    Elsewhere("tsid", "hard", {"first": 0}),
    Elsewhere("drake"),
    Elsewhere("drake", "no margins", {"margins": False}),
    Elsewhere("drake", "scaled", {"scaled": True}),
)


def strictness(
    states: int = STATES, pythons: Mapping[str, str] = MappingProxyType({})
) -> tuple[str, list[Row], list[str]]:
    """The number of states with an active limit, one row for each library, and why others are left out.

    Parameters
    ----------
    states : int
    pythons : dict of str to str
        Interpreters of the libraries that need their own, by library.

    Columns
    -------
    of each stack
        The largest `missed`, see there [m/s].
    lost
        In how many of all states it is more than `LOSS`.
    alone, lost alone
        The same, of all states, where the library is asked for the first level alone: what its tolerance, its damping,
        its way of measuring an error and of nearing limits cost, and no lower level.
    second
        The largest of the second level [rad/s], of the states that are not lost.
    """
    ticks = np.linspace(0, TICKS - 1, states).astype(int)
    streams = [record(scene, TICKS) for scene in STACKS]
    best = [list(optima(stream, ticks)) for stream in streams]
    held = [bool(np.any(solution.levels[0].active)) for own in best for _, solution in own]
    methods = [m if not isinstance(m, Elsewhere) else replace(m, python=pythons.get(m.library)) for m in METHODS]
    rows = []
    for method in methods:
        if method.missing():
            continue
        each = [missed(method, stream, ticks, known) for stream, known in zip(streams, best, strict=True)]
        alone = [missed(method, first_level(stream), ticks, known) for stream, known in zip(streams, best, strict=True)]
        first, second = np.concatenate(each).T
        (without, _) = np.concatenate(alone).T
        rows.append(
            {"method": method.name}
            | {scene.name: f"{own[:, 0].max():.0e}" for scene, own in zip(STACKS, each, strict=True)}
            | {"lost": str(np.sum(first > LOSS)), "alone": f"{without.max():.0e}"}
            | {"lost alone": str(np.sum(without > LOSS)), "second": f"{second[first <= LOSS].max(initial=0.0):.0e}"}
        )
    return f"{sum(held)} of {len(held)}", rows, [why for method in methods if (why := method.missing())]


def first_level(stream: Stream) -> Stream:
    """The same motion with the first level alone."""
    return replace(stream, scene=replace(stream.scene, levels=stream.scene.levels[:1]))


def optima(stream: Stream, ticks: Sequence[int] | Array) -> Iterator[tuple[Hierarchy, Solution]]:
    """Limits > first level > second level at each of these ticks, and the optimum, which is proved."""
    ours, solver = Ours(stream), Solver()
    for k in ticks:
        ours.aim(k)
        rows = ours.rows.fill(ours.robot.at(stream.q[k], stream.v[k]), 0.0)
        hierarchy = Hierarchy(rows.copy().levels[:3])
        solution = solver.solve(hierarchy)
        assert certify(hierarchy, solution.x).ok, f"{stream.scene.name}, tick {k}"
        yield hierarchy, solution


def missed(
    method: Own | Peer | Elsewhere,
    stream: Stream,
    ticks: Sequence[int] | Array,
    best: Sequence[tuple[Hierarchy, Solution]],
) -> Array:
    """Error of two levels of each answer beyond the one that the levels above cause, shape (ticks, 2).

    In m/s and rad/s; infinite where there is no answer.
    """
    driver = method.driver(stream)
    answers = [driver.run(k, k + 1)[1][0] for k in ticks]
    driver.close()
    return np.array([[beyond(v, *known, level) for level in (1, 2)] for v, known in zip(answers, best, strict=True)])


def beyond(v: Array, hierarchy: Hierarchy, solution: Solution, k: int) -> float:
    """Error of level k at joint velocities v beyond that of the optimum; infinite where there is no answer."""
    level = hierarchy.levels[k]
    off = float(np.linalg.norm(level.A @ v - level.lower)) - solution.levels[k].residual_norm
    return off if np.isfinite(off) else np.inf


def lost_by(stream: Stream, answers: Sequence[Array], states: int = STATES) -> list[str]:
    """The largest error of the first level beyond its optimum of each method's answers, shape (ticks, nv) each.

    ``-`` where the first level is not one position: metres and radians make no sum.
    """
    if [goal.what for goal in stream.scene.levels[0]] != ["position"]:
        return ["-"] * len(answers)
    ticks = np.linspace(0, len(stream) - 1, min(states, len(stream))).astype(int)
    best = list(optima(stream, ticks))
    return [f"{max(beyond(own[k], *known, 1) for k, known in zip(ticks, best, strict=True)):.0e}" for own in answers]
