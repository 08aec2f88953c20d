"""The map from contact forces to joint torques, and the axes of the surface: written once per tick, before rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import Array
from ..rows.site import Move

if TYPE_CHECKING:
    from ..rows.site import Workspace
    from .model import ContactModel


def keep_map(contact: ContactModel, shared: Workspace) -> tuple[Move, ...]:
    """Register the loop that writes G and the axes of a contact every tick; returns what updates its surface.

    Parameters
    ----------
    contact : Contact
    shared : Workspace
    """
    from ..base.loops import Call
    from .kernels.contact import write_contact_map

    slot, shape = contact.slot(shared), contact.shape
    known = shared.given.setdefault(id(contact), [])
    known.clear()
    G = wrench_map(contact, shared)
    count = len(shape.points) if contact in shared.unknowns else 0
    touching = contact.touching(shared)
    told = (
        shared.n,
        shared.blocks.frame(contact.frame),
        contact.wrench and bool(count),
        count,
        touching,
        shape.centre if contact.radius is None else touching,
    )
    rolls = shape.centre, np.array([contact.radius or 0.0])
    known.append(Call(write_contact_map, *told, slot.surface, contact.normal, shape.along, slot.axes, G, *rolls))
    return () if contact.surface is None else contact.surface.kept_up(slot.surface)


def wrench_map(contact: ContactModel, shared: Workspace) -> Array:
    """G of a contact, shape (unknowns, n); without rows if the contact has no forces."""
    if contact not in shared.unknowns:
        return np.zeros((0, shared.n))
    where, first = shared.unknowns.of(contact), shared.unknowns.nv
    return shared.wrenches[where.start - first : where.stop - first]
