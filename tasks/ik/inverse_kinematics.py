r"""Inverse kinematics: joint positions that solve a strict hierarchy of tasks, iterated to convergence.

Each step solves the hierarchy linearised at the present configuration (:mod:`tasks.ik.newton`). The joint ranges hold
exactly, above all levels:

.. math:: q \leftarrow q \oplus x, \qquad x = \text{lex min} \; (\lVert J_1 x - e_1 \rVert, \lVert J_2 x - e_2
    \rVert, \dots) \quad \text{within the ranges and a trust region}

*Search.* Steps are full Newton steps near a solution. Farther away, a step moves each joint by at most a share of its
distance to a limit, because a joint on its limit leaves less freedom to all others; and the trust region shrinks after
the error grew. A step that increases the error is accepted: the next one often finds a way around a local minimum. If
the error no longer falls, the search continues from the best of several random configurations.

*Settling.* From the best configuration found, a step is accepted only if it achieves its prediction: the highest level
for which the linearised hierarchy predicts a smaller error must get a given share of it, and no level above may lose.
Settling ends when no decrease is predicted for any level. So levels below the goal are met as far as possible. If the
goal cannot be met, the joints come to rest at a nearest point, and the last solution explains what stopped them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import hqp
from hqp import InvalidInput, Solution
from hqp.checks import truth, whole_number

from ..base.checks import Array, positive
from ..robots.robot import Robot, as_robot, check_states, home
from ..rows.part import Part, Stack
from .linearised import Linearised, Visit
from .newton import RADIUS, TRUST_REGION
from .pool import borrow, give_back

#: Lengths [m] and angles [rad] up to which a task counts as met.
TOLERANCE = (1e-4, 1e-3)
#: Factor on the trust region after the error grew (it doubles after the error fell), and its least radius.
SHRINK, LEAST_RADIUS = 0.5, 0.2
#: Share of the distance to its limit by which a joint may move in one step, while the error [m, rad] exceeds `NEAR`.
SHARE, NEAR = 0.3, 0.1
#: An attempt ends after this many steps in a row without an error below this share of the least one.
PATIENCE, FALL = 6, 0.8
#: Factor on the patience of the last attempt.
LAST = 4
#: Number of random configurations; the best of them starts the next attempt.
CANDIDATES = 20
#: One iteration in this many is reserved for settling while the goal is not reached.
RESERVE = 5
#: A level is at rest if its predicted decrease is below this share of the tolerance; the first one not at rest decides.
PROMISE = 1e-2
#: Share of its predicted decrease that this level must get; share of its tolerance that a level above may lose.
KEPT, LOSS = 0.1, 0.1
#: A cause weaker than this share of the pull of a level does not stop it; number of causes that are named.
FAINT, MOST_NAMED = 0.01, 3
#: Settling ends at a trust region as small as this [rad], [m].
REST = 1e-7


@dataclass(frozen=True, eq=False)
class IkResult:
    """The result of :func:`solve_ik`.

    Attributes
    ----------
    q : array, shape (nq,)
        The best configuration, inside the ranges of the joints.
    reached : bool
        Whether every task of the goal is met within the tolerance.
    errors : dict of str to dict of str to float
        Task -> unit -> norm of what is missing there, as in ``{"position": {"m": 2e-9}}``.
    iterations, restarts : int
        Number of hierarchies solved, and number of restarts.
    solution : hqp.Solution
        Solution of one more step from q; ``solution.explain()`` tells which limit or task stops each task.
    status : str
        How it ended, in words.
    """

    q: Array
    reached: bool
    errors: dict[str, dict[str, float]]
    iterations: int
    restarts: int
    solution: Solution
    status: str

    def __str__(self) -> str:
        errors = [(task, norm, unit) for task, own in self.errors.items() for unit, norm in own.items()]
        told = ", ".join(f"{task} {norm:.3g} {unit}".rstrip() for task, norm, unit in errors)
        return f"{self.status}; errors: {told}"

    def __bool__(self) -> bool:
        return self.reached


def solve_ik(
    robot: Robot,
    stack: Stack | Part,
    q0: ArrayLike | None = None,
    *,
    goal: Part | Iterable[Part] | None = None,
    tolerance: float | tuple[float, float] = TOLERANCE,
    iterations: int = 300,
    restarts: bool = True,
    settle: bool = True,
    seed: int = 0,
    backend: str = hqp.DEFAULT_BACKEND,
) -> IkResult:
    """A configuration that meets the tasks of a stack in order of priority, inside the ranges of the joints.

    Targets are evaluated at t = 0. Joint ranges in the stack hold at any level, together with the robot's own. Limits
    of speeds and accelerations, and gains, have no effect here.

    Parameters
    ----------
    robot : Robot
    stack : Stack, or a single task
        The tasks, in order of priority.
    q0 : array, shape (nq,), optional
        Where to start (default: the robot's ``home``, else neutral); moved into the ranges where it is outside.
    goal : tasks of the stack, optional
        What must be met (default: all tasks and inequalities but postures; postures where there is nothing else).
    tolerance : float or pair of float
        A length [m] and an angle [rad], or one number for both.
    iterations : int
        The most hierarchies that are solved, restarts included.
    restarts : bool
        Whether the search restarts from random configurations when it is stuck; a floating base is kept as in q0.
    settle : bool
        Whether to go on until all levels are at rest, or to stop as soon as the goal is reached. If False, no
        iterations are reserved for settling, and if the goal is not reached, q is only the best one seen.
    seed : int
        Seed of the random configurations; the same seed gives the same answer.
    backend : str
        A name from ``hqp.available_backends()``.

    Returns
    -------
    IkResult
        A goal that cannot be met raises no exception: ``reached`` is False, and q is the nearest one found.

    Raises
    ------
    InvalidInput
        If the stack does not fit the robot, has no task, or does not contain the goal; or if q0, a tolerance or the
        number of iterations is invalid.

    Examples
    --------
    >>> from tasks import PlanarArm, PositionTask, solve_ik
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> result = solve_ik(arm, PositionTask([1.0, 0.2], gain=1.0), [1.1, -1.3, -0.7])
    >>> result.reached, arm.pose(result.q)[:2].round(3)
    (True, array([1. , 0.2]))
    """
    stack = stack if isinstance(stack, Stack) else Stack(stack)
    check_states(as_robot(robot))
    most, drawn_by = whole_number(iterations, "iterations", least=1), whole_number(seed, "seed")
    again, on = truth(restarts, "restarts"), truth(settle, "settle")
    key, problem = borrow(robot, stack, goal, _tolerances(tolerance), backend)
    start = problem.inside(home(robot) if q0 is None else q0)
    best, begun = _search(problem, start, most - most // RESERVE if on else most, drawn_by if again else None)
    best, at_rest = _settle(problem, best, most) if on else (best, False)
    spent = problem.solves
    errors = problem.errors(problem.visit(best.q))
    solution = problem.solve(RADIUS)
    if not solution.ok:
        status = f"stopped, {solution.status}: {solution.message}"
    else:
        unmet = "" if best.reached or not at_rest else _why(solution, problem.unmet(best))
        status = _in_words(best.reached, spent, most, begun, unmet)
    give_back(key, problem)
    return IkResult(best.q, best.reached, errors, spent, begun, solution, status)


def _in_words(reached: bool, spent: int, most: int, begun: int, unmet: str) -> str:
    """How the search ended; `unmet` is why no step is left, if it came to rest without the goal."""
    if reached:
        return f"reached after {spent} iterations"
    if unmet:
        return f"not reached after {spent} iterations, {begun} restarts among them: {unmet}"
    return f"not reached within {most} iterations, {begun} restarts among them"


def _tolerances(value: float | tuple[float, float]) -> Array:
    pair = positive(value, "tolerance")
    if pair.shape not in {(), (2,)}:
        raise InvalidInput(f"tolerance has shape {pair.shape}; it must be a number, or a length and an angle")
    return np.broadcast_to(pair, 2)


def _search(problem: Linearised, start: Array, most: int, seed: int | None) -> tuple[Visit, int]:
    """The best configuration of all attempts, and how many were begun anew; without a seed none is."""
    rng: np.random.Generator | None = None
    here = best = problem.visit(start)
    radius, least, idle, begun = RADIUS, here.error, 0, 0
    patience = PATIENCE if seed is not None else LAST * PATIENCE
    while not best.reached and problem.solves < most:
        step = problem.solve(radius, SHARE if here.error > NEAR else 1.0)
        if not step.ok:
            break
        before, here = here, problem.visit(problem.integrate(here.q, step.x))
        best = min(best, here)
        radius = min(2.0 * radius, RADIUS) if here.error < before.error else max(SHRINK * radius, LEAST_RADIUS)
        idle = 0 if here.error < FALL * least else idle + 1
        least = min(least, here.error) if idle else here.error
        if idle >= patience:
            if seed is None:
                break
            rng = rng or np.random.default_rng(seed)
            here = problem.visit(problem.nearest(problem.random(start, rng, CANDIDATES)))
            best = min(best, here)
            radius, least, idle, begun = RADIUS, here.error, 0, begun + 1
    return best, begun


def _settle(problem: Linearised, best: Visit, most: int) -> tuple[Visit, bool]:
    """The best configuration that descent from here leads to, and whether it is at rest there."""
    radius = RADIUS
    problem.visit(best.q)
    while problem.solves < most:
        step = problem.solve(radius)
        if not step.ok:
            return best, False
        promised = best.levels - problem.left(step.x)
        decisive = np.flatnonzero(promised > PROMISE * problem.small)
        if not decisive.size or radius <= REST:
            return best, True
        here = problem.visit(problem.integrate(best.q, step.x))
        k, gained = int(decisive[0]), best.levels - here.levels
        kept = here.reached >= best.reached and bool((gained[:k] >= -LOSS * problem.small[:k]).all())
        if kept and gained[k] >= KEPT * promised[k]:
            best, radius = here, min(2.0 * radius, RADIUS)
            continue
        radius = SHRINK * min(radius, float(np.abs(step.x).max()))
        problem.visit(best.q)
    return best, False


def _why(solution: Solution, k: int) -> str:
    """What stops level k where the joints are at rest.

    A limit or task that stops it pushes back about as hard as the level pulls. If there is none, the pull itself has
    vanished, as with a stretched arm.
    """
    told, level = solution.explain().levels[k], solution.hierarchy.levels[k]
    rows = solution.hierarchy.matrix(k)
    missing = np.maximum(level.lower, 0.0) + np.minimum(level.upper, 0.0)
    pull = float(np.linalg.norm(rows, 2) * np.linalg.norm(level.weights**2 * missing))
    causes = [cause for cause in told.causes if cause.part != TRUST_REGION]
    if sum(cause.strength for cause in causes) > FAINT * pull:
        return f"{told.name} is held back by {', then '.join(map(str, causes[:MOST_NAMED]))}"
    return f"{told.name} is out of reach, no motion of the joints brings it nearer"
