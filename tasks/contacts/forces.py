"""Bounds on the forces of a contact: simple bounds of the unknowns, above all levels."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from hqp import Label

from ..base.checks import numbers
from ..base.live import structure
from ..robots.robot import Robot
from ..rows.part import Order, Part

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site
    from ..rows.unknowns import Unknowns
    from .model import ContactModel


class OfForces(Part):
    """Base class of parts whose rows act on the forces of one contact."""

    contact: ContactModel = structure()
    wide = True

    def columns(self, unknowns: Unknowns, robot: Robot) -> NDArray[np.intp]:
        where = unknowns.of(self.contact)
        return np.arange(where.start, where.stop)


class ForceBounds(OfForces):
    """Normal forces between 0 and their present caps; all forces are 0 while the contact is off.

    Parameters
    ----------
    contact : Contact
    """

    is_limit: ClassVar[bool] = True
    plain = True

    def __init__(self, contact: ContactModel) -> None:
        self.contact, self.name, self.rows = contact, f"{contact.name}: forces", contact.unknowns
        self.weight = numbers(1.0, "weight")

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        block, places = self.contact.block(), self.contact.places()
        each = len(block.names) // len(places)  # rows per point
        return [
            Label(self.name, name, unit, place=places[i // each].strip())
            for i, (name, unit) in enumerate(zip(block.names, block.units, strict=True))
        ]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.contact import write_force_bounds

        slot, contact = self.contact.slot(site.shared), self.contact
        told = slot.numbers, slot.caps, len(slot.caps), not contact.unilateral, contact.wrench, site.lower, site.upper
        return Plan((Call(write_force_bounds, *told),), (slot.move,))

    def __repr__(self) -> str:
        return f"forces of {self.contact!r}"
