"""Stacks prepared for one robot: their rows, and solvers that stay warm."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any, Literal, TypedDict

import numpy as np

import hqp
from hqp import InvalidInput, Settings, Solution, Solver
from hqp.errors import brief

from ..base.telling import tell
from ..robots.robot import Robot, RobotState, limit_of
from ..rows.hierarchy_writer import HierarchyWriter
from ..rows.part import Order, Stack
from ..rows.site import Memory
from .contacts import ForcePlaces

if TYPE_CHECKING:
    from .calm import CalmSolver

#: Damping of levels that have no rule of their own.
DefaultDamping = Literal["curvature"]
#: Number of earlier stacks that are kept ready.
MOST_PREPARED = 8


class Options(TypedDict, total=False):
    """Keyword arguments of a controller that do not depend on its order; see :class:`tasks.Controller`."""

    dt: float | None
    backend: str
    settings: Settings | None
    damping: DefaultDamping | None


def default_damping(value: object) -> DefaultDamping | None:
    """The default damping of levels, checked.

    Raises
    ------
    InvalidInput
        If `value` is neither "curvature" nor None.
    """
    if value is None or (isinstance(value, str) and value == "curvature"):
        return value  # type: ignore[return-value]  # it is "curvature" or None
    raise InvalidInput(
        f"damping = {brief(value)}; it must be 'curvature' or None. One level takes a rule by Damped(level, 0.1)"
    )


class PreparedStack:
    """A stack, its rows on one robot, and their solver.

    Parameters
    ----------
    stack : Stack
    rows : HierarchyWriter
    solver : hqp.Solver or CalmSolver

    Attributes
    ----------
    forces : ForcePlaces or None
        None where no forces are unknowns.
    """

    def __init__(self, stack: Stack, rows: HierarchyWriter, solver: Solver | CalmSolver) -> None:
        self.stack, self.rows, self.solver = stack, rows, solver
        self.forces = ForcePlaces(rows) if rows.unknowns.blocks else None

    def solve(self, state: RobotState, t: float, known: bool, fault: str | None = None) -> Solution:
        """The solution at this state and time t [s].

        Parameters
        ----------
        state : RobotState
        t : float
        known : bool
            Whether the v of the state is the x of the previous tick.
        fault : str, optional
            An error of the state: the status is then INVALID, with this message.
        """
        rows = self.rows
        if fault is None and isfinite(t):
            if isinstance(self.solver, Solver):
                return self.solver.solve(rows.fill(state, t), aims=rows.aims.by_level)
            return self.solver.solve_at(state, t, known)
        rows.hierarchy.lower.fill(np.nan)  # NaN in every bound makes the solution INVALID
        return replace(self.solver.solve(rows.hierarchy), message=fault or f"t = {t} s must be finite")


@dataclass(frozen=True)
class Preparation:
    """Prepares the stacks of one controller.

    Attributes
    ----------
    robot : Robot
    order : {"velocity", "acceleration"}
    dt : float or None
        [s].
    backend : str
    settings : hqp.Settings or None
    damping : "curvature" or None
    """

    robot: Robot
    order: Order
    dt: float | None
    backend: str
    settings: Settings | None
    damping: DefaultDamping | None

    @property
    def options(self) -> dict[str, Any]:
        """These as arguments of a controller."""
        return {"backend": self.backend, "settings": self.settings, "damping": self.damping}

    def prepare(self, stack: Stack, memory: Memory) -> PreparedStack:
        """The rows of this stack, and a cold solver.

        Raises
        ------
        InvalidInput
            If the stack does not fit the robot, or there is no such backend.
        """
        rows = stack.build(self.robot, self.order, self.dt, memory)
        return PreparedStack(stack, rows, self._solver(rows))

    def damping_of(self, rows: HierarchyWriter) -> str:
        """What the default damping leaves out of these rows, for the repr of a controller; empty if nothing."""
        if self.damping is None:
            return ", damping=None"
        if rows.levels.damps:
            return ""
        if rows.unknowns.blocks:
            return ", strict, as forces are unknowns"
        from .calm import unknown_curvatures

        left = unknown_curvatures(rows) if hqp.backend_info(self.backend).inequalities else []
        return f", damping without the curvature of {', '.join(left)}" if left else ""

    def _solver(self, rows: HierarchyWriter) -> Solver | CalmSolver:
        levels = rows.levels
        if self.damping is not None and not levels.damps and hqp.backend_info(self.backend).inequalities:
            from .calm import CalmSolver, curved_levels

            curved = curved_levels(rows)
            if any(curved):
                return CalmSolver(rows, self.dt, curved, self.backend, self.settings)
        rules: dict[int | str, hqp.DampingRule | float] = {k: rule for k, rule in enumerate(levels.damping) if rule}
        return Solver(self.backend, self.settings, rules)


class PreparedStacks:
    """The last stacks of one controller, each with its rows and its warm solver.

    Parameters
    ----------
    how : Preparation
    """

    def __init__(self, how: Preparation) -> None:
        self.how = how
        self._memory: Memory = Memory()
        self._found: dict[int, PreparedStack] = {}

    def __getitem__(self, stack: Stack) -> PreparedStack:
        """This stack with its rows and solver: as it was last used, or newly prepared."""
        found = self._found.pop(id(stack), None) or self.how.prepare(stack, self._memory)
        self._found[id(stack)] = found  # the most recent comes last
        while len(self._found) > MOST_PREPARED:
            del self._found[next(iter(self._found))]
        return found


def tell_of_speed(robot: Robot, prepared: PreparedStack) -> None:
    """Warn once if nothing limits the speed: near a singularity it grows without bound while all tasks are met."""
    held = prepared.rows.envelope.has_velocity or any(prepared.stack.damping)
    if limit_of(robot, "velocity") is None and not held:
        tell(
            f"nothing limits the speed of {robot!r}: near a singularity joints turn as fast as tasks ask;"
            " add JointVelocityLimit(2.0), in rad/s, to the top of the stack, or give the robot a velocity_limit"
        )
