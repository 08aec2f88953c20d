r"""A task: an error to be brought to zero, and one control law for both orders.

With the error :math:`e = r^d - r` (Eq. 4.6), :math:`\dot r = J \dot q` and one gain K [1/s]:

.. math::

    \text{velocity order:}\quad & J \dot q = \dot r^d + K e \\
    \text{acceleration order:}\quad & J \ddot q = \ddot r^d - \dot J \dot q + c_1 \dot e + c_2 e,
    \qquad c_1 = 2 \zeta K, \; c_2 = K^2 \quad \text{(Eq. 4.7)}

so that :math:`\dot e = -K e`, or :math:`\ddot e + c_1 \dot e + c_2 e = 0` (Eq. 4.5). The thesis's
coefficients are exactly those of :math:`\zeta = 1`, critical damping: 20 /min and 100 /min^2 are
K = 10 /min, 100 /min and 2500 /min^2 are K = 50 /min.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput, Label
from hqp.checks import of_type, whole_number
from hqp.errors import brief

from ..base.checks import Array, fill, numbers, per_row, positive, positive_scalar
from ..base.live import number, structure
from ..base.telling import tell
from ..robots.robot import Robot, RobotState, neutral
from ..targets.trajectories import Trajectory, as_trajectory
from .part import Part
from .plan import Plan, overridden
from .site import Site
from .tick import PER, Order, Tick


class Task(Part):
    r"""Base of all tasks. A task of your own needs `rows`, `error` and `jacobian`:

    >>> class HeightTask(Task):
    ...     rows = 1
    ...     def error(self, state, t):
    ...         return 0.5 - state.pose[1:2]
    ...     def jacobian(self, state):
    ...         return state.jacobian[1:2]
    >>> HeightTask(gain=2.0)
    HeightTask(gain=2)

    Parameters
    ----------
    gain : float or array, shape (rows,)
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``; a row of weight 0 asks for
        nothing.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off [m], [rad], so that far targets are approached at a speed of at most K
        times it: one number for the length of the whole error, or one for each row. The direction of the error stays.
    deceleration : float, optional
        The target is approached only so fast that this deceleration [m/s^2], [rad/s^2] brings it to rest there,
        by :math:`v \le \sqrt{2 a d}` for the length d of the error.
    name : str, optional
        Used in messages, tables and records (default: the name of the class).

    Raises
    ------
    InvalidInput
        If a gain or the damping ratio is not positive, a weight negative, or one of them larger than 1e15; names task
        and row. With a controller, if the gain makes the error grow from tick to tick.
    """

    rows: int | None = structure(None)
    says: ClassVar[tuple[str, ...]] = ("error", "jacobian", "drift", "feedforward", "rates", "measure", "write")

    def __init__(
        self,
        *,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        self._call(name)
        self.gain, self.weight, self.damping_ratio = gain, weight, damping_ratio
        self.cap, self.deceleration = cap, deceleration
        self._renew()

    @number
    def gain(self, value: ArrayLike) -> Array:
        """K [1/s], shape () or (rows,)."""
        return positive(value, f"{self.full_name()}: gain", unit="1/s")

    @number
    def damping_ratio(self, value: float) -> float:
        """The zeta of acceleration order."""
        return positive_scalar(value, f"{self.full_name()}: damping ratio")

    @number
    def cap(self, value: ArrayLike | None) -> Array | None:
        """Length to which the error is cut off [m], [rad], shape () or (rows,); None for no limit."""
        return None if value is None else positive(value, f"{self.full_name()}: cap", unit="m or rad")

    @number
    def deceleration(self, value: float | None) -> float | None:
        """Deceleration with which it comes to rest at its target [m/s^2], [rad/s^2]; None for no bound."""
        what = f"{self.full_name()}: deceleration"
        return None if value is None else positive_scalar(value, what, unit="m/s^2 or rad/s^2")

    def _renew(self) -> None:
        rows = self.rows
        if rows is None:
            return
        if type(rows) is not int or rows < 1:
            whole_number(rows, f"{self.full_name()}: rows", least=1)
        self._check_rows(rows, "gain", "weight", "cap")

    def _check_rows(self, rows: int, *names: str) -> None:
        """Refuse numbers that are neither one for all rows nor one a row."""
        for name in names:
            value = getattr(self, name)
            if value is not None and value.ndim:
                per_row(value, rows, f"{self.full_name()}: {name}")

    def _call(self, name: str | None) -> None:
        """Take this name, before anything is refused in it."""
        default = type(self).__name__.removesuffix("Task").lower()
        self.name = default if name is None else of_type(name, str, f"name of a {type(self).__name__}")

    def error(self, state: RobotState, t: float) -> Array:
        """``e = desired - actual`` (Eq. 4.6) at time t [s], shape (rows,), in [m] or [rad]."""
        raise NotImplementedError(f"{type(self).__name__} must define error(state, t)")

    def jacobian(self, state: RobotState) -> Array:
        """Derivative of the actual value by the joint motion, shape (rows, nv)."""
        raise NotImplementedError(f"{type(self).__name__} must define jacobian(state)")

    def drift(self, state: RobotState) -> Array | float:
        """``Jdot v``, shape (rows,); needed at acceleration order where the Jacobian changes."""
        return 0.0

    def decay_rate(self) -> float:
        """``zeta K`` [1/s] of its fastest row."""
        return self.damping_ratio * float(self.gain.max())

    def feedforward(self, t: float) -> tuple[Array | float, Array | float]:
        """Velocity and acceleration of the desired value at time t [s]; zero for one that stands still."""
        return 0.0, 0.0

    def rates(self, state: RobotState, t: float) -> tuple[Array | float, Array | float]:
        """The feed-forward as the rows have it, where their axes turn with the robot."""
        return self.feedforward(t)

    def python_plan(self, site: Site) -> Plan:
        """Measured in Python, by the methods above; the law is that of all tasks."""
        if type(self).write is not Part.write:
            return super().python_plan(site)
        from ..base.loops import Call
        from .kernels.law import write_law

        error, rate, change, drift, now = site.measured
        A = np.zeros((site.rows, site.shared.robot.nv)) if site.A is None else site.A
        what = {word: f"{self.full_name()}: {word}" for word in ("error", "jacobian", "drift", "feedforward")}

        def measure(tick: Tick) -> None:
            state, t = tick.state, tick.t
            fill(error, self.error(state, t), what["error"])
            velocity, acceleration = self._rates(state, t)
            fill(rate, velocity, f"{what['feedforward']} velocity", spread=True)
            fill(change, acceleration, f"{what['feedforward']} acceleration", spread=True)
            if site.A is not None or site.drifts:
                fill(A, self.jacobian(state), what["jacobian"])
            if site.drifts:
                fill(drift, self.drift(state), what["drift"], spread=True)
                np.dot(A, state.v, out=now)

        return Plan(
            (Call(write_law, site.law(self)),), python=measure, why=f"{type(self).__name__} is measured in Python"
        )

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        """Name and unit of each row, as of the error: ``("x", "m")``."""
        return [(label.row, "") for label in super().labels(robot, "velocity")]

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        return [Label(self.name, row, unit and unit + PER[order]) for row, unit in self.row_names(robot)]

    @staticmethod
    def at_rest(robot: Robot) -> RobotState:
        """The state at which a task is checked: the neutral configuration, without motion."""
        return robot.at(neutral(robot), np.zeros(robot.nv))

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        self.check_numbers(robot, order, dt)
        if self.in_python:
            self._try(robot, order)

    def check_numbers(self, robot: Robot, order: Order, dt: float | None) -> None:
        self._check_rows(self.size(robot), "gain", "cap")
        self.check_gain(order, dt)

    @property
    def in_python(self) -> bool:
        """Whether Python measures it, and not a loop."""
        return type(self).plan is Part.plan or overridden(type(self), self.says) is not None

    def _try(self, robot: Robot, order: Order) -> None:
        """Measure once at the neutral configuration: what does not fit is refused here, not in the loop."""
        rows, state = self.size(robot), self.at_rest(robot)
        feedforward = self._rates(state, 0.0)
        spread: list[tuple[int, ...]] = [(rows,), ()]  # one number a row, or one for all
        parts: list[tuple[str, Any, list[tuple[int, ...]]]] = [
            ("error", self.error(state, 0.0), [(rows,)]),
            ("jacobian", self.jacobian(state), [(rows, robot.nv)]),
            ("feedforward velocity", feedforward[0], spread),
            ("feedforward acceleration", feedforward[1], spread),
        ]
        if order == "acceleration":
            parts.append(("drift", self.drift(state), spread))
        for what, value, allowed in parts:
            shape = numbers(value, f"{self.full_name()}: {what}").shape
            if shape not in allowed:
                shapes = " or ".join(map(str, allowed))
                raise InvalidInput(f"{self.full_name()}: {what} has shape {shape}; with this robot it must be {shapes}")

    def _rates(self, state: RobotState, t: float) -> tuple[Array | float, Array | float]:
        """The checked pair of :meth:`rates`."""
        given = self.rates(state, t)
        if not (isinstance(given, tuple) and len(given) == 2):
            raise InvalidInput(f"{self.full_name()}: feedforward = {brief(given)} must be (velocity, acceleration)")
        return given

    def check_gain(self, order: Order, dt: float | None) -> None:
        r"""Refuse a gain that makes the error grow from tick to tick, and tell once of one that passes the target.

        With the command held over a tick, :math:`e^+ = (1 - K dt) e` at velocity order, and at acceleration order a
        matrix whose eigenvalues lie in the unit circle as long as :math:`\zeta K dt < 1` and :math:`K dt < 4 \zeta`.

        Raises
        ------
        InvalidInput
        """
        if dt is None or order == "displacement":  # which is taken as a whole, whatever the gain
            return
        fastest, zeta = float(self.gain.max()), self.damping_ratio
        most = 2.0 if order == "velocity" else min(1.0 / zeta, 4.0 * zeta)
        if fastest * dt > most * (1.0 + 1e-9):
            raise InvalidInput(
                f"{self.full_name()}: gain = {fastest:g} 1/s makes the error grow from tick to tick of {dt:g} s at"
                f" {order} order; it must be at most {most / dt:g}"
            )
        if order == "velocity" and fastest * dt > 1.0 + 1e-9:
            tell(
                f"{self.full_name()}: gain = {fastest:g} 1/s passes the target in every tick of {dt:g} s and comes"
                f" back; above {1.0 / dt:g} it is not reached sooner"
            )

    def __repr__(self) -> str:
        parts = [f"gain={_short(self.gain)}"]
        if self.damping_ratio != 1.0:
            parts.append(f"damping_ratio={self.damping_ratio:g}")
        if np.any(self.weight != 1.0):
            parts.append(f"weight={_short(self.weight)}")
        if self.cap is not None:
            parts.append(f"cap={_short(self.cap)}")
        if self.deceleration is not None:
            parts.append(f"deceleration={self.deceleration:g}")
        if self.name != type(self).__name__.removesuffix("Task").lower():
            parts.append(f"name={self.name!r}")
        return f"{type(self).__name__}({', '.join(self._shown() + parts)})"

    def _shown(self) -> list[str]:
        """The arguments in the repr before the gain."""
        return []


class TargetTask(Task):
    """A task whose desired value is given: an array that stands still, or a trajectory.

    Subclasses define `measure` and `jacobian`.

    Parameters
    ----------
    target : array, shape (rows,), or Trajectory
        Desired value in [m] or [rad]; a trajectory brings its own feed-forward.
    gain : float or array, shape (rows,)
        K [1/s]: the rate at which the error decays.
    damping_ratio : float
        The zeta of acceleration order; 1 is critical damping.
    weight : float or array, shape (rows,)
        Weight of the rows inside their level, against those of other tasks joined by ``+``.
    cap : float or array, shape (rows,), optional
        Length to which the error is cut off, in its unit; a far target is approached at K times that.
    deceleration : float, optional
        The deceleration with which it comes to rest at its target [m/s^2], [rad/s^2].
    name : str, optional
        Used in messages, tables and records (default: the name of the class).
    """

    def __init__(
        self,
        target: ArrayLike | Trajectory,
        *,
        gain: ArrayLike,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        cap: ArrayLike | None = None,
        deceleration: float | None = None,
        name: str | None = None,
    ) -> None:
        super().__init__(
            gain=gain, damping_ratio=damping_ratio, weight=weight, cap=cap, deceleration=deceleration, name=name
        )
        self.target = target

    @number
    def target(self, value: ArrayLike | Trajectory) -> Trajectory:
        """The desired value [m], [rad]: numbers, shape (rows,), or a trajectory."""
        return as_trajectory(value, self.rows, self.full_name())

    def measure(self, state: RobotState) -> Array:
        """The actual value r, shape (rows,)."""
        raise NotImplementedError(f"{type(self).__name__} must define measure(state)")

    def error(self, state: RobotState, t: float) -> Array:
        return self.target(t)[0] - self.measure(state)

    def feedforward(self, t: float) -> tuple[Array, Array]:
        _, velocity, acceleration = self.target(t)
        return velocity, acceleration

    def _shown(self) -> list[str]:
        return [repr(self.target)]


def _short(value: Array) -> str:
    return f"{float(value):.4g}" if value.ndim == 0 else str([float(f"{x:.4g}") for x in value])
