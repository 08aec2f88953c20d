"""The controller: robot state in, joint velocities, accelerations or torques out, one call a tick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Generic, Literal, Unpack, get_args, overload

import numpy as np
from numpy.typing import ArrayLike

import hqp
from hqp import InvalidInput, Settings, Status
from hqp.checks import one_of, truth

from ..base.checks import Array, finite_scalar, numbers, positive_scalar, scalar
from ..base.live import Live, structure
from ..robots.robot import Robot, as_robot, check_joints
from ..rows.description import Description
from ..rows.hierarchy_writer import HierarchyWriter
from ..rows.part import Command, Order, Part, Stack
from ..targets.timing import Timing, cubic
from . import contacts as of
from .prepared import DefaultDamping, Options, Preparation, PreparedStacks, default_damping, tell_of_speed
from .states import StateReader
from .step import Acceleration, Step, Torque, Velocity
from .torques import torques_of
from .transition import Limits, Transition

if TYPE_CHECKING:
    from ..contacts.contact import Contact

#: Makes a step from all its fields, at a third of the price of its own `__new__`.
new = tuple.__new__


class Controller(Live, Generic[Velocity, Acceleration, Torque]):
    """Computes the command of every tick from a stack of tasks, each solve warm-started from the last.

    A copy, by ``copy.deepcopy`` or pickle, is an independent controller with its own robot and tasks: make one for each
    environment or thread. It goes on with changes, releases and contacts as they are; its solver starts cold.

    Parameters
    ----------
    robot : Robot
    stack : Stack, or a single task
        The tasks, in order of priority.
    order : {"velocity", "acceleration", "torque"}
        The kind of command. Torques are those of the accelerations that the same stack gives at acceleration order;
        for a floating base they need contacts, and :class:`tasks.Dynamics` in the stack.
    dt : float, optional
        Time between two calls [s]; limits and the simulation need it.
    backend : str
        A name from ``hqp.available_backends()``.
    settings : hqp.Settings, optional
    torque : bool
        Whether steps at acceleration order also contain joint torques, by the robot's ``inverse_dynamics``.
    damping : "curvature" or None
        Damping of a stack that has none of its own (:class:`~tasks.Damped` levels, or ``task + Damping()``).
        "curvature": levels are relaxed where their linearisation is inaccurate, near singularities and out of reach,
        and only in those directions; joint velocities then change smoothly there and close to limits. Joints without
        an acceleration limit come to rest at the ends of their ranges with at most 30 rad/s^2, unless a limit in space
        needs more. Elsewhere the answer is the strict one. ``step.relaxed`` and ``step.solution.explain()`` show where
        levels are relaxed; ``Damped(level, None)`` keeps a level strict. Tasks of one's own without a curvature are not
        calmed, and the repr names them. None: every level is strict. All levels are also strict if the stack has
        damping of its own, if no part has curvature (as postures), if contact forces are unknowns (then see
        docs/contacts.md, "Tasks out of reach"), and with closed-form backends, which take no inequalities.

    Raises
    ------
    InvalidInput
        At once: if the robot or the stack is not one, the order or the damping is none of these, dt is not positive,
        the backend is unknown, a task does not fit the robot or its gain does not fit dt; or if torques are asked for
        at velocity order, or of a robot that cannot compute them or has a free base.

    Examples
    --------
    >>> from tasks import Controller, JointVelocityLimit, OrientationTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> stack = JointVelocityLimit(2.0) >> PositionTask([0.9, 0.6], gain=2.0) >> OrientationTask(0.0, gain=2.0)
    >>> controller = Controller(arm, stack, dt=0.01)
    >>> step = controller([1.1, -1.3, -0.7])
    >>> step.v.round(3), step.solution.certify().ok
    (array([ 2.   , -1.191,  0.61 ]), True)
    >>> print(step.solution.explain())
    velocity limit met (1 of 3 rows at a bound)
    position met (rank 2 of 2)
    orientation short by 0.381 rad/s: position, then joint 0 velocity limit (upper)
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
        torque: Literal[False] = ...,
        **options: Unpack[Options],
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[None, Array, None],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Literal["acceleration"],
        torque: Literal[False] = ...,
        **options: Unpack[Options],
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[None, Array, Array],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Literal["acceleration"],
        torque: Literal[True],
        **options: Unpack[Options],
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[None, Array, Array],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Literal["torque"],
        torque: bool = ...,
        **options: Unpack[Options],
    ) -> None: ...
    @overload
    def __init__(
        self: Controller[Any, Any, Any],
        robot: Robot,
        stack: Stack | Part,
        *,
        order: Command = ...,
        torque: bool = ...,
        **options: Unpack[Options],
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
        wanted = stack if isinstance(stack, Stack) else Stack(stack)
        self.order = order
        self.dt = None if dt is None else positive_scalar(dt, "dt", unit="s")
        asked = truth(torque, "torque") or order == "torque"
        self._torques = torques_of(self.robot, wanted, order) if asked else None
        motion: Order = "velocity" if order == "velocity" else "acceleration"
        how = Preparation(self.robot, motion, self.dt, backend, settings, default_damping(damping))
        self._prepared = PreparedStacks(how)
        self._forces: of.Forces | None = None
        self._pressed: dict[str, Array] = {}  # what a copy has instead until its first tick
        self._transition: Transition | None = None
        self._limits: Limits | None = None
        self._states = StateReader(self.robot)
        self._rest = np.zeros(self.robot.nv)
        self._now = self._prepared[wanted]
        tell_of_speed(self.robot, self._now)

    def __getstate__(self) -> dict[str, Any]:
        """Its arguments, its pending changes, oldest first, and what its contacts keep; not its rows and solvers."""
        asked = {"order": self.order, "torque": self._torques is not None and self.order != "torque", "dt": self.dt}
        return {
            "robot": self.robot,
            "stack": self.stack,
            "options": asked | self._prepared.how.options,
            "changes": [] if self._transition is None else self._transition.history(),
            "kept": of.kept(self._rows),
            "pressed": self._pressed if self._forces is None else of.pressed(self._forces),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        changes = state["changes"]
        stacks = [*(left for left, *_ in changes), state["stack"]]
        Controller.__init__(self, state["robot"], stacks[0], **state["options"])
        for (_, duration, law, since), stack in zip(changes, stacks[1:], strict=True):
            self.change(stack, duration=duration, law=law)
            assert self._transition is not None
            self._transition.since = since
        of.take(state["kept"], self._rows)
        self._pressed = state["pressed"]

    @property
    def stack(self) -> Stack:
        """The stack that is solved at present; :meth:`change` replaces it."""
        return self._now.stack

    @property
    def _rows(self) -> HierarchyWriter:
        return self._now.rows

    @property
    def backend(self) -> str:
        """Name of the backend."""
        return self._now.solver.backend

    @property
    def hierarchy(self) -> hqp.Hierarchy:
        """The rows of the last tick (views: the next call overwrites them)."""
        return self._rows.hierarchy

    @property
    def aims(self) -> Mapping[int | str, Array]:
        """What damped levels were damped towards at the last tick (views), by level; those without are zero."""
        return self._rows.aims.by_level or {}

    def __call__(
        self, q: ArrayLike, v: ArrayLike | None = None, t: float = 0.0
    ) -> Step[Velocity, Acceleration, Torque]:
        """The command for this tick.

        Parameters
        ----------
        q : array, shape (nq,)
            Joint positions [rad].
        v : array, shape (nv,)
            Joint velocities [rad/s]. At velocity order None means unknown: limits then take the robot to be at rest,
            and nothing else uses them.
        t : float
            Time [s], for targets that move, and by which contacts are made and released, and stacks changed.

        Raises
        ------
        InvalidInput
            If q, v or t has the wrong shape, or v is None at an order that needs it. Values never raise: if a number
            that a row goes by is not finite, or a quaternion or a point on a circle does not have norm 1, the status
            of the solution is INVALID and nothing moves. A v that only the default damping looks at is then unknown.
        InUse
            If another thread is in this controller, or in another one of the same robot with a shared workspace.
        """
        if v is None and self.order != "velocity":
            raise InvalidInput(f"v = None, but order = {self.order!r} needs the joint velocities, shape (nv,)")
        position, velocity = numbers(q, "q"), None if v is None else numbers(v, "v")
        check_joints(self.robot, position, self._rest if velocity is None else velocity)
        return self.unchecked(position, velocity, t if type(t) is float else scalar(t, "t"))

    def unchecked(self, q: Array, v: Array | None, t: float) -> Step[Velocity, Acceleration, Torque]:
        """The command for this tick, for callers that pass float arrays q and v of the right shape."""
        guard = self._states.guard
        try:
            guard.take()
        except IndexError:
            guard.refuse()
        try:
            if self._now.rows.compiled:
                return self._step(q, v, t)
            with np.errstate(all="ignore"):
                return self._step(q, v, t)
        finally:
            guard.give(None)

    def _step(
        self, q: Array, v: Array | None, t: float, refused: str | None = None
    ) -> Step[Velocity, Acceleration, Torque]:
        state, fault = self._states.read(q, self._rest if v is None else v)
        known = v is not None and self.order == "velocity"
        solution = self._now.solve(state, t, known, fault or refused)
        x, share = solution.x, 1.0
        if self._transition is not None and solution.ok:
            x, share = self._transition.blend(state, t, x, known)
            if share >= 1.0:
                self._transition = None
            elif self._limits is not None:
                x = self._limits.keep(self.hierarchy, x)
        if self.order == "velocity":
            return new(Step, ("velocity", state, solution, x, None, None, share, None))
        tau = None
        if self._torques is not None:
            tau = self._torques(self._rows, state, x, solution.status is not Status.INVALID)
            if tau is None:  # rows that no wrench or bias is in were valid
                return self._step(q, v, t, "the torques are not finite")
        places, forces = self._now.forces, None
        if places is not None:
            forces = places.forces(x)
            if solution.status is not Status.INVALID:
                self._forces = forces  # from which a release goes on
            x = x[: self.robot.nv]
        return new(Step, (self.order, state, solution, None, x, tau, share, forces))

    def release(self, contact: Contact | str, duration: float = 0.0) -> None:
        """Release a contact: the caps of its normal forces fall from the present forces to 0, then its motion is freed.

        Before the first tick, which tells forces, they fall from the weight of the robot, 1000 N if its base is fixed.
        The structure of the hierarchy does not change, and the solver stays warm.

        Parameters
        ----------
        contact : Contact or its name
        duration : float
            Time in which the forces fall [s]; the bounds of its motion then take as long to open.

        Raises
        ------
        InvalidInput
            If the contact is not in the stack or is off already, or the duration is negative.
        """
        forces = self._pressed if self._forces is None else of.pressed(self._forces)
        of.release(self.stack, self._rows, forces, contact, duration)

    def make(self, contact: Contact | str, duration: float = 0.0) -> None:
        """Make a contact that is off or being released: from the next tick on it holds the position it then has.

        Parameters
        ----------
        contact : Contact or its name
        duration : float
            Time [s] in which the cap on the sum of its normal forces grows from 0 to the weight of the robot, or to
            1000 N if its base is fixed; afterwards there is no cap.

        Raises
        ------
        InvalidInput
            If the contact is not in the stack or is on already, or the duration is negative.
        """
        of.make(self.stack, self._rows, contact, duration)

    def settle(self) -> None:
        """Hold all contacts and loops where the next tick finds them, as before the first tick.

        For a robot that has been put somewhere else; :func:`tasks.simulate` does so at the start of every run.
        """
        of.settle(self._rows)

    @property
    def loaded(self) -> tuple[str, ...]:
        """The names of contacts that may have forces now: those that are on, until a release has lowered them to 0."""
        return of.loaded(self.stack, self._rows)

    def bears(self, contact: Contact | str) -> bool:
        """Whether a contact of the stack counts as support: on, and not being released.

        Raises
        ------
        InvalidInput
            If it is no contact of the stack.
        """
        return of.bears(self.stack, self._rows, contact)

    def change(self, stack: Stack | Part, *, duration: float, law: Timing = cubic) -> None:
        """Change to another stack without a jump, from the next tick on; see :mod:`tasks.control.transition`.

        The limits at the top of the new stack hold from the first tick on, even if the old stack has none. Its contacts
        and loops hold where that tick finds them, unless they are in the old stack, too. If a change
        is still under way, the new one starts from its present command. A stack that the controller had before is
        found with its rows and its warm solver.

        Parameters
        ----------
        stack : Stack, or a single task
            The new stack; it may have the same parts as the old one, in another order.
        duration : float
            How long the change takes [s]; 0 for at once.
        law : callable
            How the change proceeds in time: ``cubic``, ``quintic``, ``harmonic``, ``cycloid``, or your own timing law.

        Raises
        ------
        InvalidInput
            If the stack does not fit the robot, the duration is negative, or the law is not a timing law. The
            controller then continues unchanged.
        """
        wanted = stack if isinstance(stack, Stack) else Stack(stack)
        new, old = self._prepared[wanted], self._now
        at_once = finite_scalar(duration, "duration of a change") == 0.0
        of.check_change(old.stack, old.rows, wanted, new.rows, self.order, at_once)
        leaving = [] if self._transition is None else [stack for stack, *_ in self._transition.history()]
        self._transition = None if at_once else Transition(old, self._transition, duration, law)
        of.settle(new.rows, (part for stack in (old.stack, *leaving) for part in stack))
        self._now = new
        self._limits = None if at_once else Limits.of(new.rows.levels, self.hierarchy, self.backend)

    def bounds(self, part: Part) -> tuple[Array, Array]:
        """Lower and upper bounds of a part's rows at the last tick (views: the next call overwrites them).

        A contact has rows on several levels, listed by :meth:`describe`: forces, motion and friction. Its bounds are
        those of all these rows in this order, as a copy.

        Raises
        ------
        InvalidInput
            If the part is not in the stack.
        """
        found = self._rows.places.bounds(part)
        if found is None:
            raise InvalidInput(f"{part!r} is not in the stack {self.stack!r}")
        return found

    def error(self, part: Part) -> Array | None:
        """The error of a task as its rows had it at the last tick (a view: the next call overwrites it).

        It is ``part.error(step.state, t)``, but need not be computed again. None where the rows do not have it: of
        parts that are no tasks or not in the stack, of inequalities, and where `cap` or `deceleration` is set.
        """
        return self._rows.places.error(part)

    def describe(self) -> Description:
        """Who writes the rows of each part of the present stack every tick: a compiled loop, by its name, or Python.

        ``print`` it as a table, or iterate over the parts, the highest level first: each has `level`, `part`, `rows`,
        `loops`, `python` and, where Python writes, `why`.
        """
        return self._rows.describe()

    def __repr__(self) -> str:
        tick = "" if self.dt is None else f", dt={self.dt:g}"
        tick += self._prepared.how.damping_of(self._rows)
        ends = self._rows.shared.envelope.eased
        tick += "" if np.isinf(ends) else f", at ends of ranges {ends:g} rad/s^2"
        tick += ", torque=True" if self._torques is not None and self.order == "acceleration" else ""
        return f"Controller({self.robot!r}, {self.stack!r}, order={self.order!r}{tick}, backend={self.backend!r})"
