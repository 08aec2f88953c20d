"""The controller: robot state in, joint velocities, accelerations or torques out, one call a tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any, Generic, Literal, get_args, overload

import numpy as np
from numpy.typing import ArrayLike

import hqp
from hqp import InvalidInput, Settings, Solution, Solver, Status
from hqp.checks import one_of, truth
from hqp.errors import brief
from hqp.guard import Guard

from ..base.checks import Array, finite_scalar, numbers, positive_scalar, scalar
from ..base.live import Live, structure
from ..base.telling import tell
from ..robots.robot import (
    Robot,
    RobotState,
    as_robot,
    check_fixed_base,
    check_joints,
    check_states,
    inverse_dynamics,
    limit_of,
    workspace,
)
from ..rows.description import Description
from ..rows.part import Command, Order, Part
from ..rows.rows import Rows
from ..rows.stack import Stack
from ..targets.timing import Timing, cubic
from . import contacts as of
from .step import A, Step, T, V
from .transition import Limits, Transition

if TYPE_CHECKING:
    from ..contacts.contact import Contact
    from ..rows.site import Memory
    from .calm import CalmSolver

#: How levels are damped that have no rule of their own.
DefaultDamping = Literal["curvature"]
#: Stacks that a controller keeps ready to go back to.
MOST_PREPARED = 8


def _by_the_rows(q: Array, v: Array, a: Array) -> Array:
    """Stands for what tells torques where the stack has the motion equation: its own arrays do."""
    raise NotImplementedError


class _Left:
    """What a controller leaves behind in a change: its stack, with rows and solver, and what it was coming from.

    Called, it gives x, and whether it claims it.
    """

    def __init__(self, stack: Stack, rows: Rows, solver: Solver | CalmSolver, before: Transition | None) -> None:
        self.stack, self._rows, self._solver, self.before = stack, rows, solver, before

    def __call__(self, state: RobotState, t: float, last: Array | None = None) -> tuple[Array, bool]:
        self._rows.fill(state, t)
        solution = _answer(self._solver, self._rows, last)
        if self.before is None or not solution.ok:
            return solution.x, solution.ok
        return self.before.blend(state, t, solution.x, last)[0], True


def _answer(solver: Solver | CalmSolver, rows: Rows, last: Array | None) -> Solution:
    """What a solver says to the rows as they are; `last` is the x of the tick before, None where nobody knows."""
    if isinstance(solver, Solver):
        return solver.solve(rows.hierarchy, aims=rows.aims)
    return solver.solve(rows.hierarchy, last)


def _damping(value: object) -> DefaultDamping | None:
    """How levels are damped by default, if it is a way to do so."""
    if value is None or (isinstance(value, str) and value == "curvature"):
        return value  # type: ignore[return-value]  # which is this very word
    raise InvalidInput(
        f"damping = {brief(value)}; it must be 'curvature' or None. One level takes a rule by Damped(level, 0.1)"
    )


class Controller(Live, Generic[V, A, T]):
    """Turns a stack of tasks into motion, tick by tick, warm from the last.

    A copy, by ``copy.deepcopy`` or pickle, is a controller of its own, with a robot and tasks of its own: one for each
    environment or thread. It is made from what defines it, and begins cold.

    Parameters
    ----------
    robot : Robot
    stack : Stack, or a single task
        What is wanted, in order of priority.
    order : {"velocity", "acceleration", "torque"}
        What the robot is commanded with. Torques are those of the accelerations that the same stack gives at
        acceleration order. A base that floats needs contacts, and :class:`tasks.Dynamics` in the stack.
    dt : float, optional
        Time between two calls [s]; limits need it, and the simulation.
    backend : str
        A name from ``hqp.available_backends()``.
    settings : hqp.Settings, optional
    torque : bool
        Whether steps tell the joint torques too, at acceleration order, by the robot's ``inverse_dynamics``.
    damping : "curvature" or None
        What is done where the stack has no damping of its own (:class:`~tasks.Damped` levels, or ``task + Damping()``).
        "curvature": levels give way where their rows mislead, near singularities and out of reach, in the directions
        in which they do, and joints change their velocities calmly there and close to limits; in reach the answer is
        the strict one. ``step.relaxed`` and ``step.solution.explain()`` tell where. A level is left out of it by
        ``Damped(level, None)``. None: every level is strict. So it is where the stack is damped by itself, where no
        part of it bends, as postures do not, where forces of contacts are unknowns too, and with backends of closed
        forms, which take no inequalities.

    Raises
    ------
    InvalidInput
        At once, if the robot or the stack is none, the order or the damping is none of these, dt is not positive, the
        backend is unknown, a task does not fit the robot or its gain the tick, or torques are asked for at velocity
        order, or of a robot that cannot tell them or has a base that moves freely.
    """

    robot: Robot = structure()
    order: Command = structure()
    dt: float | None = structure()
    _instead = "make a controller of its own; to another stack it goes over by controller.change(stack, duration=...)"

    @overload
    def __init__(
        self: Controller[Array, None, None],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Literal["velocity"] = ...,
        dt: float | None = ...,
        backend: str = ...,
        settings: Settings | None = ...,
        torque: Literal[False] = ...,
        damping: DefaultDamping | None = ...,
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[None, Array, None],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Literal["acceleration"],
        dt: float | None = ...,
        backend: str = ...,
        settings: Settings | None = ...,
        torque: Literal[False] = ...,
        damping: DefaultDamping | None = ...,
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[None, Array, Array],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Literal["acceleration"],
        dt: float | None = ...,
        backend: str = ...,
        settings: Settings | None = ...,
        torque: Literal[True],
        damping: DefaultDamping | None = ...,
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[None, Array, Array],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Literal["torque"],
        dt: float | None = ...,
        backend: str = ...,
        settings: Settings | None = ...,
        torque: bool = ...,
        damping: DefaultDamping | None = ...,
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[Any, Any, Any],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Command = ...,
        dt: float | None = ...,
        backend: str = ...,
        settings: Settings | None = ...,
        torque: bool = ...,
        damping: DefaultDamping | None = ...,
    ) -> None: ...
    def __init__(
        self,
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Command = "velocity",
        dt: float | None = None,
        backend: str = hqp.DEFAULT_BACKEND,
        settings: Settings | None = None,
        torque: bool = False,
        damping: DefaultDamping | None = "curvature",
    ) -> None:
        one_of(order, get_args(Command), "order")
        self.robot = as_robot(robot)
        self._stack = stack if isinstance(stack, Stack) else Stack(stack)
        self.order = order
        self.dt = None if dt is None else positive_scalar(dt, "dt", unit="s")
        self._torque = self._inverse_dynamics() if truth(torque, "torque") or order == "torque" else None
        self._memory: Memory = {}
        self._forces: of.Forces | None = None
        self._backend, self._settings, self._damping = backend, settings, _damping(damping)
        self._prepared: dict[int, tuple[Stack, Rows, Solver | CalmSolver]] = {}
        self._transition: Transition | None = None
        self._limits: Limits | None = None
        # Where configurations lie on a manifold, the controller looks at them itself: a call never raises for a state.
        # A robot whose states share a workspace has a guard of its own, for all controllers that it has.
        shared = workspace(robot)
        self._on_manifold = None if shared is None else shared.on_manifold
        self._state: Callable[[Array, Array], RobotState] = self.robot.at if shared is None else shared.state
        self._guard = Guard("the controller") if shared is None else shared.guard
        check_states(robot)
        self._rest = np.zeros(self.robot.nv)
        self._rows, self._solver = self._prepare(self.stack)
        self._tell_of_speed()

    def _tell_of_speed(self) -> None:
        """Tell once where nothing limits the speed: near a singularity it grows without end, and all tasks are met."""
        held = self._rows.envelope.has_velocity or any(self.stack.damping)
        if limit_of(self.robot, "velocity") is None and not held:
            tell(
                f"nothing limits the speed of {self.robot!r}: near a singularity joints turn as fast as tasks ask;"
                " add JointVelocityLimit(2.0), in rad/s, to the top of the stack, or give the robot a velocity_limit"
            )

    def __getstate__(self) -> dict[str, Any]:
        """What defines it, and the changes under way, the oldest first: rows and solvers are made anew, and cold."""
        changes, change = list[tuple[Stack, float, Timing, float | None]](), self._transition
        while change is not None:
            left = change.old
            assert isinstance(left, _Left)
            changes.insert(0, (left.stack, change.duration, change.law, change.begin))
            change = left.before
        settings, torque = self._settings, self._torque is not None and self.order != "torque"
        own: dict[str, Any] = {
            "order": self.order,
            "dt": self.dt,
            "backend": self._backend,
            "settings": settings,
            "torque": torque,
            "damping": self._damping,
        }
        off = of.off(self.stack, self._rows)
        return {"robot": self.robot, "stack": self.stack, "options": own, "changes": changes, "off": off}

    def __setstate__(self, state: dict[str, Any]) -> None:
        changes = state["changes"]
        stacks = [*(left for left, *_ in changes), state["stack"]]
        Controller.__init__(self, state["robot"], stacks[0], **state["options"])
        for (_, duration, law, begin), stack in zip(changes, stacks[1:], strict=True):
            self.change(stack, duration=duration, law=law)
            assert self._transition is not None
            self._transition.begin = begin
        of.let_go(state["off"], self._rows)

    def _inverse_dynamics(self) -> Callable[[Array, Array, Array], Array]:
        asked = "order = 'torque'" if self.order == "torque" else "torque = True"
        if self.order == "velocity":
            raise InvalidInput(f"torque = True, but order = {self.order!r} gives no accelerations; it must be False")
        of.check_torques(self.stack)
        if of.has_dynamics(self.stack):
            return _by_the_rows
        check_fixed_base(self.robot, asked)
        method = inverse_dynamics(self.robot)
        if method is None:
            raise InvalidInput(f"{asked}, but {self.robot!r} has no inverse_dynamics(q, v, a)")
        return method

    @property
    def stack(self) -> Stack:
        """What is wanted at present; :meth:`change` goes over to another one."""
        return self._stack

    @property
    def backend(self) -> str:
        """Name of the backend."""
        return self._solver.backend

    @property
    def hierarchy(self) -> hqp.Hierarchy:
        """The rows of the last tick (views: the next call refills them)."""
        return self._rows.hierarchy

    @property
    def aims(self) -> Mapping[int | str, Array]:
        """What damped levels were damped towards at the last tick (views), by level; those without are zero."""
        return self._rows.aims or {}

    def __call__(self, q: ArrayLike, v: ArrayLike | None = None, t: float = 0.0) -> Step[V, A, T]:
        """The motion for this tick.

        Parameters
        ----------
        q : array, shape (nq,)
            Joint positions [rad].
        v : array, shape (nv,)
            Joint velocities [rad/s]. None, at velocity order: they are not known. The robot is then taken to be at rest
            where limits ask, and no command leans on them.
        t : float
            Time [s], for targets that move.

        Raises
        ------
        InvalidInput
            If q, v or t has the wrong shape, or v is None at an order that needs it. Numbers never raise: where they
            are not finite, or a quaternion or a point of a circle has not norm 1, the status of the solution is INVALID
            and nothing moves.
        InUse
            If another thread is inside, or in another controller of the same robot, where it has one workspace.
        """
        if v is None and self.order != "velocity":
            raise InvalidInput(f"v = None, but order = {self.order!r} needs the joint velocities, shape (nv,)")
        position, velocity = numbers(q, "q"), self._rest if v is None else numbers(v, "v")
        time = t if type(t) is float else scalar(t, "t")
        check_joints(self.robot, position, velocity)
        return self.unchecked(position, None if v is None else velocity, time)

    def unchecked(self, q: Array, v: Array | None, t: float) -> Step[V, A, T]:
        """The motion for this tick, for a loop which knows that q and v are float arrays of the right shape."""
        if self._rows.compiled:  # which never warns
            return self._step(q, v, t)
        with np.errstate(all="ignore"):
            return self._step(q, v, t)

    def _step(self, q: Array, v: Array | None, t: float) -> Step[V, A, T]:
        with self._guard:
            return self._guarded(q, v, t)

    def _guarded(self, q: Array, v: Array | None, t: float) -> Step[V, A, T]:
        fault = None
        if self._on_manifold is not None:
            q, fault = self._on_manifold(q)
        state = self._state(q, self._rest if v is None else v)
        last = v if self.order == "velocity" else None
        solution = self._solve(state, t, last, fault)
        x, share = solution.x, 1.0
        if self._transition is not None and solution.ok:
            x, share = self._transition.blend(state, t, x, last)
            if share >= 1.0:
                self._transition = None
            elif self._limits is not None:
                x = self._limits.keep(self.hierarchy, x)
        step: Any = Step  # what it has, the overloads of __init__ tell
        if self.order == "velocity":
            return step("velocity", state, solution, x, share=share)  # type: ignore[no-any-return]
        tau = None if self._torque is None else self._torques(state, x, solution.status is not Status.INVALID)
        if self._rows.unknowns.blocks:
            self._forces = of.Forces(self._rows, x)
            x = x[: self._rows.unknowns.nv]
        return step(self.order, state, solution, None, x, tau, share, self._forces)  # type: ignore[no-any-return]

    def _torques(self, state: RobotState, x: Array, valid: bool) -> Array:
        """What x takes; zero where there are no numbers: what goes to a motor is finite, whatever a sensor says."""
        assert self._torque is not None
        if self._torque is _by_the_rows:
            tau = of.joint_torques(self._rows, x)
        elif valid:
            tau = self._torque(state.q, state.v, x)
        else:
            return np.zeros_like(x)
        return tau if valid and np.isfinite(tau).all() else np.zeros_like(tau)

    def release(self, contact: Contact | str, duration: float = 0.0) -> None:
        """Let a contact go: the largest normal forces fall from what they are to 0; then its motion is let go.

        Nothing of the structure changes, and the solver stays warm.

        Parameters
        ----------
        contact : Contact or its name
        duration : float
            How long the forces take to fall, and then the bounds of its motion to open [s].

        Raises
        ------
        InvalidInput
            If it is no contact of the stack, or off already, or the duration is negative.
        """
        of.release(self.stack, self._rows, self._forces, contact, duration)

    def make(self, contact: Contact | str, duration: float = 0.0) -> None:
        """Make a contact that is off, or being released: from the next tick on it holds where it then is.

        Parameters
        ----------
        contact : Contact or its name
        duration : float
            In which the sum of its normal forces may grow, from 0 up to the weight of the robot, or 1000 N where its
            base is fixed [s]; then freely.

        Raises
        ------
        InvalidInput
            If it is no contact of the stack, or on already, or the duration is negative.
        """
        of.make(self.stack, self._rows, contact, duration)

    @property
    def loaded(self) -> tuple[str, ...]:
        """The names of the contacts that may bear forces at present: those that are on, unless all theirs are gone."""
        return of.loaded(self.stack, self._rows)

    def change(self, stack: Stack | Part, *, duration: float, law: Timing = cubic) -> None:
        """Go over to another stack without a jump, from the next tick on; see :mod:`tasks.control.transition`.

        The limits that the new stack begins with hold from the first tick on, also where the old one has none. A change
        that is still under way is left from where it is. Going back to a stack that the controller has had
        finds all as it was: rows, and a solver that is warm.

        Parameters
        ----------
        stack : Stack, or a single task
            What is wanted from now on; its parts may be those of the old one, in another order.
        duration : float
            How long the change takes [s]; 0 for at once.
        law : callable
            How it goes: ``cubic``, ``quintic``, ``harmonic``, ``cycloid``, or your own timing law.

        Raises
        ------
        InvalidInput
            If the stack does not fit the robot, the duration is negative, or the law is none. The controller then
            goes on as it was.
        """
        wanted = stack if isinstance(stack, Stack) else Stack(stack)
        prepared = self._prepare(wanted)
        at_once = finite_scalar(duration, "duration of a change") == 0.0
        of.check_change(self.stack, self._rows, wanted, prepared[0], self.order, at_once)
        left = _Left(self.stack, self._rows, self._solver, self._transition)
        self._transition = None if at_once else Transition(left, duration, law)
        self._stack, (self._rows, self._solver) = wanted, prepared
        self._limits = None if at_once else Limits.of(self._rows.stack, self.hierarchy, self._backend)

    def _new_solver(self, stack: Stack, rows: Rows) -> Solver | CalmSolver:
        damps = self._damping is not None and not stack.damps
        if damps and hqp.backend_info(self._backend).inequalities:
            from .calm import CalmSolver, curved_levels

            curved = curved_levels(rows)
            if any(curved):
                return CalmSolver(rows, self.dt, curved, self._backend, self._settings)
        rules: dict[int | str, hqp.DampingRule | float] = {k: rule for k, rule in enumerate(stack.damping) if rule}
        return Solver(self._backend, self._settings, rules)

    def _prepare(self, stack: Stack) -> tuple[Rows, Solver | CalmSolver]:
        """The rows of a stack, and their solver, as they were left."""
        found = self._prepared.pop(id(stack), None)
        if found is None:
            order: Order = "velocity" if self.order == "velocity" else "acceleration"
            rows = stack.build(self.robot, order, self.dt, self._memory)
            found = stack, rows, self._new_solver(rows.stack, rows)
        self._prepared[id(stack)] = found  # what was asked for last comes last
        while len(self._prepared) > MOST_PREPARED:
            del self._prepared[next(iter(self._prepared))]
        return found[1:]

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

    def describe(self) -> Description:
        """Who writes the rows of each part every tick: a compiled loop, by its name, or Python, and why.

        Returns
        -------
        Description
            To be printed as a table, or iterated over: part by part, from the highest level down, with `level`, `part`,
            `rows`, `loops`, `python` and `why`. Of the present stack; one that a change still comes from is not told.
        """
        return self._rows.describe()

    def _solve(self, state: RobotState, time: float, last: Array | None, fault: str | None) -> Solution:
        if fault is None and isfinite(time):
            self._rows.fill(state, time)
            return _answer(self._solver, self._rows, last)
        self.hierarchy.lower.fill(np.nan)  # no task is asked, and no bound left that could be met
        solution, message = self._solver.solve(self.hierarchy), fault or f"t = {time} s must be finite"
        return replace(solution, message=message)

    def __repr__(self) -> str:
        tick = "" if self.dt is None else f", dt={self.dt:g}"
        tick += "" if self._damping else ", damping=None"
        tick += ", torque=True" if self._torque is not None and self.order == "acceleration" else ""
        return f"Controller({self.robot!r}, {self.stack!r}, order={self.order!r}{tick}, backend={self.backend!r})"
