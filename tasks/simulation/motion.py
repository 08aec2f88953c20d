"""The motion of a robot over one tick under its command, and checks of what plants receive and return."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.arrays import real_array

from ..base.checks import Array, finite, positive_scalar
from ..contacts.contact import Contact
from ..contacts.loop import Loop
from ..control.step import Step
from ..robots.robot import Robot, base, check_joints
from ..targets.turns import stands_still


def follow(
    integrate: Callable[[Array, Array], Array], step: Step[Any, Any, Any], q: Array, v: Array, dt: float
) -> tuple[Array, Array, Array]:
    """Configuration and velocities at the end of a tick dt [s] under the command `step`, and the accelerations over it.

    From configuration q and velocities v; `integrate(q, displacement)` is that of the robot.
    """
    if step.a is not None:
        a: Array = step.a
        return integrate(q, dt * v + (0.5 * dt * dt) * a), v + dt * a, a
    assert step.v is not None
    after: Array = step.v.copy()
    return integrate(q, dt * after), after, (after - v) / dt


def told(
    robot: Robot, q: ArrayLike, v: ArrayLike, tau: ArrayLike, dt: float, what: str
) -> tuple[Array, Array, Array, float]:
    """The checked inputs of a plant for one tick, in the sizes and units of this robot.

    Raises
    ------
    InvalidInput
        If a number is not finite, or an array has another size than the robot's; `what` names the plant.
    """
    q, v, tau = finite(q, f"{what}: q"), finite(v, f"{what}: v"), finite(tau, f"{what}: tau")
    motors = robot.nv - base(robot)
    try:
        check_joints(robot, q, v)
    except InvalidInput as error:
        raise InvalidInput(f"{what} of {robot!r}: {error}") from None
    if tau.shape != (motors,):
        raise InvalidInput(
            f"{what} of {robot!r}: tau has shape {tau.shape}; it must be ({motors},), one a motor, in N m"
        )
    return q, v, tau, positive_scalar(dt, f"{what}: dt", unit="s")


def check_moved(robot: Robot, moved: Any, what: str) -> tuple[Array, Array]:
    """The checked q and v that a plant returned; they may be infinite or NaN.

    Raises
    ------
    InvalidInput
        If the plant returned anything else.
    """
    try:
        given_q, given_v = moved
    except (TypeError, ValueError):
        raise InvalidInput(f"{what}: advance gave {type(moved).__name__}; it must be (q, v), two arrays") from None
    q, v = real_array(given_q, f"{what}: advance gave q, which"), real_array(given_v, f"{what}: advance gave v, which")
    if q.shape != (robot.nq,) or v.shape != (robot.nv,):
        raise InvalidInput(
            f"{what}: advance gave shapes {q.shape} and {v.shape}; {robot!r} has ({robot.nq},) and ({robot.nv},)"
        )
    return q, v


def check_still(contact: Contact, what: str) -> None:
    """Refuse a contact with a surface that moves: what it touches in the plant `what` stands.

    Raises
    ------
    InvalidInput
    """
    surface = contact.surface
    if surface is not None and not (stands_still(surface.position) and stands_still(surface.rotation)):
        raise InvalidInput(f"{what}: {contact.full_name()}: its surface moves, {surface!r}; it must stand still")


def check_names(contacts: Sequence[Contact], loops: Sequence[Loop] = ()) -> None:
    """Refuse contacts and loops with the same name, because forces are identified by it.

    Raises
    ------
    InvalidInput
    """
    names = [part.name for part in (*contacts, *loops)]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInput(f"contacts: two of them are called {name!r}; give them names of their own")
