"""Contacts of a controller at work: their forces and centres of pressure, joint torques, release and make."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array, finite_scalar, suggestion
from ..contacts.contact import Contact
from ..contacts.loop import Loop
from ..contacts.slot import Slot
from ..robots.robot import Robot, base, mass_matrix, neutral
from ..rows.hierarchy_writer import HierarchyWriter

if TYPE_CHECKING:
    from ..rows.part import Part, Stack

#: Cap on the normal forces of a contact while it is being made: the weight of the robot, with this gravity [m/s^2]; or,
#: if the base is fixed and the weight unknown, this force [N].
GRAVITY, FIXED = 9.81, 1000.0
#: Of each contact or loop with forces, by its name: where these are in x, and where its axes are among all axes.
Places: TypeAlias = "dict[str, tuple[Contact | Loop, slice, slice]]"


class ForcePlaces:
    """Where the forces of each contact are among all unknowns of a stack, the same at every tick.

    Parameters
    ----------
    rows : HierarchyWriter
    """

    def __init__(self, rows: HierarchyWriter) -> None:
        unknowns, shared = rows.unknowns, rows.shared
        self._axes: list[Array] = [np.zeros(0)]
        self._places: Places = {}
        last = 0
        for block in unknowns.blocks:
            owner, first = block.owner, last
            assert isinstance(owner, Contact | Loop)
            if isinstance(owner, Contact):
                self._axes.append(owner.slot(shared).axes)
                last += len(self._axes[-1])
            self._places[block.name] = owner, unknowns.of(owner), slice(first, last)

    def forces(self, x: Array) -> Forces:
        """The forces in x, the answer of this tick."""
        return Forces(self._places, x, np.concatenate(self._axes))


class Forces(Mapping[str, Array]):
    """The forces of one tick, by the names of the contacts, each computed when it is asked for.

    ``forces["left"]`` are the forces of the world on the robot, in world axes: at every point, shape (k, 3) [N]; for a
    contact with one wrench, shape (6,), [N] and [N m] about its centre. :meth:`cop` gives the centre of pressure.
    """

    def __init__(self, places: Places, x: Array, axes: Array) -> None:
        self._places, self._x, self._axes = places, x, axes

    def __getitem__(self, name: str) -> Array:
        found = self._places.get(name)
        if found is None:
            raise KeyError(f"{name!r} is no contact{suggestion(str(name), self._places)}")
        owner, own, axes = found
        f = self._x[own]
        return owner.forces(f, self._axes[axes]) if isinstance(owner, Contact) else owner.forces(f)

    def cop(self, name: str) -> Array:
        """The centre of pressure of a contact in the coordinates of its frame, shape (3,) [m]; NaN without pressure."""
        contact, f, axes = self._find(name)
        return contact.cop(f, axes)

    def normal(self, name: str) -> Array:
        """The normal force at every point [N]."""
        contact, f, _ = self._find(name)
        return contact.normal_forces(f)

    def _find(self, name: str) -> tuple[Contact, Array, Array]:
        found = self._places.get(name)
        if found is None or not isinstance(found[0], Contact):
            raise KeyError(f"{name!r} is no contact{suggestion(str(name), self.contacts)}")
        return found[0], self._x[found[1]], self._axes[found[2]]

    @property
    def contacts(self) -> tuple[str, ...]:
        """The names of the contacts, without loops."""
        return tuple(name for name, (owner, _, _) in self._places.items() if isinstance(owner, Contact))

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def __repr__(self) -> str:
        return f"Forces({', '.join(f'{name}: {self[name].round(3).tolist()}' for name in self)})"


class Pressures(Mapping[str, Array]):
    """The centres of pressure of one tick, by the names of the contacts, in the coordinates of their frames [m]."""

    def __init__(self, forces: Forces) -> None:
        self._forces = forces

    def __getitem__(self, name: str) -> Array:
        return self._forces.cop(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._forces.contacts)

    def __len__(self) -> int:
        return len(self._forces.contacts)

    def __repr__(self) -> str:
        return f"Pressures({', '.join(f'{name}: {self[name].round(4).tolist()}' for name in self)})"


def has_dynamics(stack: Stack) -> bool:
    """Whether the motion equation is in a stack."""
    return any(part.is_dynamics for part in stack)


def check_torques(stack: Stack) -> None:
    """Refuse torques for a stack with contacts whose forces are not computed.

    Raises
    ------
    InvalidInput
    """
    for part in stack:
        if isinstance(part, Contact) and not has_dynamics(stack):
            raise InvalidInput(
                f"{part.full_name()}: torques hang on its forces, and the stack has no Dynamics(); add it beside"
                " the contacts"
            )


def check_change(
    old: Stack, old_rows: HierarchyWriter, new: Stack, new_rows: HierarchyWriter, order: str, at_once: bool
) -> None:
    """Refuse a change to a stack with other unknowns: forces of different contacts cannot be interpolated.

    Raises
    ------
    InvalidInput
    """
    if order == "torque":
        check_torques(new)
        if has_dynamics(old) != has_dynamics(new):
            raise InvalidInput("change: only one of both stacks has Dynamics(); both must have it, or none")
    if not at_once and not old_rows.unknowns.alike(new_rows.unknowns):
        raise InvalidInput(
            "change: the new stack has other contacts; put all of them into both stacks, and release and make them, or"
            " change with duration=0"
        )


def weight_of(robot: Robot) -> float:
    """The largest sum of normal forces of a contact while it is being made [N]."""
    inertia = mass_matrix(robot)
    return GRAVITY * float(inertia(neutral(robot))[0, 0]) if base(robot) and inertia is not None else FIXED


def find_contact(stack: Iterable[Part], contact: Contact | str) -> Contact:
    """A contact of a stack, or of some parts, given as the object or by its name.

    Raises
    ------
    InvalidInput
        If there is none; the message lists the nearest names.
    """
    own = [part for part in stack if isinstance(part, Contact)]
    found = [part for part in own if part is contact] or [part for part in own if part.name == contact]
    if len(found) > 1:
        raise InvalidInput(
            f"{contact!r} names {len(found)} contacts of the stack; give each a name of its own: name=..."
        )
    if found:
        return found[0]
    what = repr(contact) if not isinstance(contact, str) else f"{contact!r}"
    raise InvalidInput(f"{what} is no contact of the stack{suggestion(str(contact), [part.name for part in own])}")


def release(
    stack: Stack, rows: HierarchyWriter, forces: Mapping[str, Array], contact: Contact | str, duration: float
) -> None:
    """See :meth:`tasks.Controller.release`."""
    found, time = find_contact(stack, contact), _duration(duration, "release")
    slot = found.slot(rows.shared)
    if not slot.on:
        raise InvalidInput(f"{found.full_name()}: is off already; it can be made")
    present = forces.get(found.name)
    if present is None:  # no tick has told them: each point may bear the robot
        present = np.full(len(slot.caps), weight_of(rows.shared.robot) if found in rows.unknowns else 0.0)
    slot.release(np.maximum(present, 0.0), time)


def make(stack: Stack, rows: HierarchyWriter, contact: Contact | str, duration: float) -> None:
    """See :meth:`tasks.Controller.make`."""
    found, time = find_contact(stack, contact), _duration(duration, "make")
    slot = found.slot(rows.shared)
    if slot.bears:
        raise InvalidInput(f"{found.full_name()}: is on already; it can be released")
    slot.make(max(weight_of(rows.shared.robot), found.least) if found in rows.unknowns else 0.0, time)


def bears(stack: Stack, rows: HierarchyWriter, contact: Contact | str) -> bool:
    """See :meth:`tasks.Controller.bears`; a contact object may also belong to another stack of the controller."""
    found = contact if isinstance(contact, Contact) else find_contact(stack, contact)
    return found.slot(rows.shared).bears


def loaded(stack: Stack, rows: HierarchyWriter) -> tuple[str, ...]:
    """The names of the contacts that may bear forces."""
    return tuple(part.name for part in stack if isinstance(part, Contact) and part.slot(rows.shared).loaded)


def kept(rows: HierarchyWriter) -> list[tuple[Contact | Loop, Slot | Array]]:
    """What contacts and loops keep from tick to tick: which are on, where they hold, and ramps under way.

    Those of all stacks that the controller has had: it may be leaving one of them, and may go back to it.
    """
    return [(part, own) for part, own in rows.shared.memory.items() if isinstance(part, Contact | Loop)]


def take(all_of: list[tuple[Contact | Loop, Slot | Array]], rows: HierarchyWriter) -> None:
    """Go on with what contacts and loops kept."""
    for part, own in all_of:
        if isinstance(part, Contact) and isinstance(own, Slot):
            part.slot(rows.shared).take(own)
        elif isinstance(part, Loop) and isinstance(own, np.ndarray):
            part.held(rows.shared)[:] = own


def settle(rows: HierarchyWriter, held: Iterable[Part] = ()) -> None:
    """Hold all contacts and loops but these where the next tick finds them, of all stacks of the controller."""
    staying = {id(part) for part in held}
    for part in rows.shared.memory:
        if id(part) in staying:
            continue
        if isinstance(part, Contact):
            part.slot(rows.shared).settle()
        elif isinstance(part, Loop):
            part.settle(rows.shared)


def pressed(forces: Forces | None) -> dict[str, Array]:
    """The normal forces at the points of all contacts, by name [N]."""
    return {} if forces is None else {name: forces.normal(name) for name in forces.contacts}


def _duration(value: float, what: str) -> float:
    duration = finite_scalar(value, f"{what}: duration")
    if duration < 0.0:
        raise InvalidInput(f"{what}: duration = {duration:g} s must not be negative")
    return duration
