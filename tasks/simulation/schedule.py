"""What is switched when in a run: checked as a whole before it begins, as a switch that fails would end it midway."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from hqp import InvalidInput

from ..control.contacts import find_contact

if TYPE_CHECKING:
    from ..control.controller import Controller
    from .simulation import Change, Switch


def check_switches(controller: Controller, schedule: Iterable[Change | Switch]) -> None:
    """Go through a schedule, in the order of time, and refuse a switch that finds its contact as it would leave it.

    Raises
    ------
    InvalidInput
        Also if the contact is none of the stack that is solved by then.
    """
    from .simulation import Change

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
