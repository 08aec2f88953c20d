r"""Friction: linear rows which allow only contact forces that do not slip.

At each point the rows are the pyramid of m faces inside the cone :math:`\lVert f_t \rVert \le \mu f_n`,

.. math:: d_i^T f_t \le \mu \cos(\pi / m) f_n, \qquad d_i = (\cos(2 \pi i / m), \sin(2 \pi i / m)).

A contact with one wrench, force f and moment m about its centre, has one pyramid. Its centre of pressure stays in the
rectangle of lengths :math:`l_1, l_2`, and its moment about the normal is bounded:

.. math:: |m_1| \le \tfrac12 l_2 f_n, \qquad |m_2| \le \tfrac12 l_1 f_n, \qquad |m_n| \le \tau f_n .

One more row bounds the sum of the normal forces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hqp import Label

from ..base.checks import Array, numbers
from ..robots.robot import Robot
from ..rows.part import Order
from .forces import OfForces

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site
    from .model import ContactModel


class Friction(OfForces):
    """Friction rows of a contact, without bounds while it is off.

    Parameters
    ----------
    contact : Contact
    """

    is_limit: ClassVar[bool] = True

    def __init__(self, contact: ContactModel) -> None:
        self.contact, self.name = contact, f"{contact.name}: friction"
        self.weight = numbers(1.0, "weight")
        self.rows = len(self.matrix(1.0))

    def matrix(self, mu: float) -> Array:
        """The matrix of all rows, for the forces of this contact only, shape (rows, unknowns)."""
        contact = self.contact
        angles = 2.0 * np.pi * np.arange(contact.faces) / contact.faces
        least = np.full(contact.faces, -mu * np.cos(np.pi / contact.faces))
        pyramid = np.column_stack([np.cos(angles), np.sin(angles), least])
        normal = np.zeros((1, contact.unknowns))
        if not contact.wrench:
            normal[0, 2::3] = 1.0
            return np.concatenate([np.kron(np.eye(len(contact.shape.points)), pyramid), normal])
        assert contact.lengths is not None
        l1, l2 = contact.lengths
        torsion = 0.25 * mu * (l1 + l2) if contact.torsion is None else contact.torsion
        normal[0, 2] = 1.0
        moments = np.zeros((6, 6))
        for k, arm in enumerate((0.5 * l2, 0.5 * l1, torsion)):
            moments[2 * k : 2 * k + 2, 3 + k], moments[2 * k : 2 * k + 2, 2] = (1.0, -1.0), -arm
        return np.concatenate([np.pad(pyramid, ((0, 0), (0, 3))), moments, normal])

    def labels(self, robot: Robot, order: Order) -> list[Label]:
        contact, name = self.contact, self.name
        found = [
            Label(name, f"{at}face {i}", "N", place=at.strip() or "point")
            for at in contact.places()
            for i in range(contact.faces)
        ]
        if contact.wrench:
            edges = ("edge at t2 > 0", "edge at t2 < 0", "edge at t1 < 0", "edge at t1 > 0")
            found += [Label(f"{contact.name}: sole", edge, "N m") for edge in edges]
            found += [Label(f"{contact.name}: torsion", turn, "N m") for turn in ("left", "right")]
        return [*found, Label(f"{contact.name}: normal force", "sum", "N")]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.contact import write_friction

        contact = self.contact
        assert site.A is not None
        assert contact.friction is not None
        site.A[:] = 0.0
        site.A[:, site.shared.unknowns.of(contact)] = self.matrix(contact.friction)
        total = np.array([contact.least, contact.largest])
        slot = contact.slot(site.shared)
        return Plan((Call(write_friction, slot.numbers, site.rows, total, site.lower, site.upper),))

    def __repr__(self) -> str:
        return f"friction of {self.contact!r}"
