"""The schedule of a run: changes of its stack and switches of its contacts, all checked before the run begins."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from hqp import InvalidInput
from hqp.checks import of_type, truth

from ..base.checks import finite_scalar, not_negative, scalar
from ..contacts.contact import Contact
from ..control.contacts import find_contact
from ..control.controller import Controller
from ..rows.part import Stack
from ..targets.timing import Timing, as_timing, cubic


@dataclass(frozen=True, eq=False)
class Change:
    """A change to another stack at a time of the simulation; see :meth:`tasks.Controller.change`.

    Attributes
    ----------
    t : float
        When [s].
    stack : Stack
    duration : float
        How long it takes [s].
    law : callable
        A timing law.

    Raises
    ------
    InvalidInput
        If a time is not finite, a duration is negative, or the stack or the law is none.

    Examples
    --------
    >>> from tasks import Change, Controller, OrientationTask, PlanarArm, PositionTask, simulate
    >>> arm, place = PlanarArm([0.5, 0.5, 0.5]), PositionTask([1.0, 0.2], gain=5.0)
    >>> other = Change(0.5, OrientationTask(0.0, gain=5.0) >> place, duration=0.2)
    >>> record = simulate(Controller(arm, place, dt=0.01), [1.1, -1.3, -0.7], duration=1.0, changes=[other])
    >>> bool(abs(record.errors["orientation"][-1, 0]) < 0.1)
    True
    """

    t: float
    stack: Stack
    duration: float
    law: Timing = cubic

    def __post_init__(self) -> None:
        _check_times(self, "a change")
        object.__setattr__(self, "stack", self.stack if isinstance(self.stack, Stack) else Stack(self.stack))
        as_timing(self.law, "a change: law")


@dataclass(frozen=True, eq=False)
class Switch:
    """A contact that is made or released, see :meth:`tasks.Controller.make` and :meth:`tasks.Controller.release`.

    Attributes
    ----------
    t : float
        When [s].
    contact : Contact or its name
    on : bool
        True to make it, False to release it.
    duration : float
        How long that takes [s].

    Raises
    ------
    InvalidInput
        If a time is not finite, a duration is negative, `on` is no truth value, or the contact is none.

    Examples
    --------
    >>> from tasks import Switch
    >>> Switch(1.6, "right", on=False, duration=0.2).on
    False
    """

    t: float
    contact: Contact | str
    on: bool
    duration: float = 0.0

    def __post_init__(self) -> None:
        _check_times(self, "a switch")
        object.__setattr__(self, "on", truth(self.on, "a switch: on"))
        if not isinstance(self.contact, Contact):
            of_type(self.contact, str, "a switch: contact")


def _check_times(change: Change | Switch, what: str) -> None:
    object.__setattr__(change, "t", finite_scalar(change.t, f"{what}: t"))
    scalar(not_negative(change.duration, f"{what}: duration", unit="s"), f"{what}: duration")


def check_switches(controller: Controller, schedule: Iterable[Change | Switch]) -> None:
    """Check the switches of a schedule, which is in the order of time.

    Raises
    ------
    InvalidInput
        If the contact of a switch is already made, or released, by then, or does not belong to the stack at that time.
    """
    stack, on = controller.stack, dict[int, bool]()
    for change in schedule:
        if isinstance(change, Change):
            stack = change.stack
            continue
        try:
            contact = find_contact(stack, change.contact)
        except InvalidInput as refusal:
            raise InvalidInput(f"a switch at t = {change.t:g} s, by when another stack is solved: {refusal}") from None
        if on.get(id(contact), controller.bears(contact)) == change.on:
            there, other = ("on", "released") if change.on else ("off", "made")
            raise InvalidInput(
                f"a switch at t = {change.t:g} s: {contact.full_name()} is {there} already by then; it can be {other}"
            )
        on[id(contact)] = change.on
