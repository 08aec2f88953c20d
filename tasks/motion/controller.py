"""One call a tick: robot state in, motion out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isfinite
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

import hqp
from hqp import InvalidInput, RegularisedSolution, RegularisedSolver, Relaxation, Settings, Solution
from hqp.checks import truth

from .._checks import Array, numbers, positive_scalar, scalar
from ..part import Order, Part
from ..robots.robot import Robot, RobotState, as_robot, check_joints
from ..stack import Stack


class Step(NamedTuple):
    """What the controller says for one tick.

    Attributes
    ----------
    order : {"velocity", "acceleration"}
    state : RobotState
        Where the robot was.
    solution : hqp.Solution, or hqp.RegularisedSolution where a level is damped
        How well every level is met; ``.certify().ok`` is the proof.
    v : array, shape (nv,), or None
        Joint velocities [rad/s], at velocity order.
    a : array, shape (nv,), or None
        Joint accelerations [rad/s^2], at acceleration order.
    tau : array, shape (nv,), or None
        Joint torques [N m] that a takes (Eq. 4.1), if the controller was asked for them.
    """

    order: Order
    state: RobotState
    solution: Solution | RegularisedSolution
    v: Array | None = None
    a: Array | None = None
    tau: Array | None = None

    @property
    def ok(self) -> bool:
        """Whether the solver claims the optimum; look at ``solution`` otherwise."""
        return self.solution.ok

    @property
    def relaxed(self) -> tuple[Relaxation, ...]:
        """What strictness was given up: lambda and residual norm of every damped level, highest first."""
        return self.solution.relaxed if isinstance(self.solution, RegularisedSolution) else ()


class Controller:
    """Turns a stack of tasks into motion, tick by tick, warm from the last.

    Parameters
    ----------
    robot : Robot
    stack : Stack, or a single task
        What is wanted, in order of priority.
    order : {"velocity", "acceleration"}
        What the robot is commanded with.
    dt : float, optional
        Time between two calls [s]; limits need it, and the simulation.
    backend : str
        A name from ``hqp.available_backends()``.
    settings : hqp.Settings, optional
    torque : bool
        Whether steps tell the joint torques too, at acceleration order, by the robot's ``inverse_dynamics``.

    Raises
    ------
    InvalidInput
        At once, if the robot or the stack is none, the order is neither, dt is not positive, the
        backend is unknown, a task does not fit the robot, or torques are asked for at velocity order or
        of a robot that cannot tell them.
    """

    def __init__(
        self,
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Order = "velocity",
        dt: float | None = None,
        backend: str = hqp.DEFAULT_BACKEND,
        settings: Settings | None = None,
        torque: bool = False,
    ) -> None:
        if order not in get_args(Order):
            raise InvalidInput(f"order = {order!r}; it must be one of {', '.join(map(repr, get_args(Order)))}")
        self.robot = as_robot(robot)
        self.stack = stack if isinstance(stack, Stack) else Stack(stack)
        self.order: Order = order
        self.dt = None if dt is None else positive_scalar(dt, "dt", unit="s")
        self._torque = self._inverse_dynamics() if truth(torque, "torque") else None
        self._rows = self.stack.build(robot, order, self.dt)
        rules: dict[int | str, hqp.DampingRule | float] = {k: rule for k, rule in enumerate(self.stack.damping) if rule}
        self._solver: hqp.Solver | RegularisedSolver = (
            RegularisedSolver(rules, backend, settings) if rules else hqp.Solver(backend, settings)
        )

    def _inverse_dynamics(self) -> Callable[[Array, Array, Array], Array]:
        if self.order != "acceleration":
            raise InvalidInput(f"torque = True, but order = {self.order!r} gives no accelerations; it must be False")
        method: Callable[[Array, Array, Array], Array] | None = getattr(self.robot, "inverse_dynamics", None)
        if method is None:
            raise InvalidInput(f"torque = True, but {self.robot!r} has no inverse_dynamics(q, v, a)")
        return method

    @property
    def backend(self) -> str:
        """Name of the backend."""
        return self._solver.backend

    @property
    def hierarchy(self) -> hqp.Hierarchy:
        """The rows of the last tick (views: the next call refills them)."""
        return self._rows.hierarchy

    def __call__(self, q: ArrayLike, v: ArrayLike, t: float = 0.0) -> Step:
        """The motion for this tick.

        Parameters
        ----------
        q : array, shape (nq,)
            Joint positions [rad].
        v : array, shape (nv,)
            Joint velocities [rad/s].
        t : float
            Time [s], for targets that move.

        Raises
        ------
        InvalidInput
            If q, v or t has the wrong shape. Numbers never raise: where they are not finite the
            status of the solution is INVALID.
        """
        position, velocity = numbers(q, "q"), numbers(v, "v")
        time = t if type(t) is float else scalar(t, "t")
        check_joints(self.robot, position, velocity)
        return self.unchecked(position, velocity, time)

    def unchecked(self, q: Array, v: Array, t: float) -> Step:
        """The motion for this tick, for a loop which knows that q and v are float arrays of the right shape."""
        if self._rows.compiled:  # which never warns
            return self._step(q, v, t)
        with np.errstate(all="ignore"):
            return self._step(q, v, t)

    def _step(self, q: Array, v: Array, t: float) -> Step:
        state = self.robot.at(q, v)
        solution = self._solve(state, t)
        if self.order == "velocity":
            return Step("velocity", state, solution, solution.x)
        tau = None if self._torque is None else self._torque(state.q, state.v, solution.x)
        return Step("acceleration", state, solution, None, solution.x, tau)

    def bounds(self, part: Part) -> tuple[Array, Array]:
        """Lower and upper bounds of a part's rows at the last tick (views: the next call refills them).

        Raises
        ------
        InvalidInput
            If the part is not in the stack.
        """
        found = self._rows.bounds(part)
        if found is None:
            raise InvalidInput(f"{part!r} is not in the stack {self.stack!r}")
        return found

    def _solve(self, state: RobotState, time: float) -> Solution | RegularisedSolution:
        if isfinite(time):
            self._rows.fill(state, time)
            return self._solver.solve(self.hierarchy)
        self.hierarchy.lower.fill(np.nan)  # no task is asked, and no bound left that could be met
        solution, message = self._solver.solve(self.hierarchy), f"t = {time} s must be finite"
        if isinstance(solution, RegularisedSolution):
            return replace(solution, plain=replace(solution.plain, message=message))
        return replace(solution, message=message)

    def __repr__(self) -> str:
        tick = "" if self.dt is None else f", dt={self.dt:g}"
        tick += "" if self._torque is None else ", torque=True"
        return f"Controller({self.robot!r}, {self.stack!r}, order={self.order!r}{tick}, backend={self.backend!r})"
