r"""The forces that bear a robot at rest: what levels that are damped pull contact forces towards.

Damped towards no force, a level would hold its robot up less. At every tick forces are pulled towards the least ones
whose normal parts push, and that meet the rows of the base at :math:`a = 0`, :math:`G_u^T f = b_u`. These hang on the
state, and on which contacts are on, alone: nothing is remembered, so the same state has the same answer. Friction is
not regarded, nor are other bounds of forces; but a point that pushes has tangential forces up to its normal force, and
none bears more than all: where no such forces bear the robot they are cut off there, and bear it less.

Each force at a point counts the same. Wrenches are made of forces at the corners of their rectangle, so that both kinds
of a contact bear the same. A contact that is being made or released takes the share of its ramp.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import Array
from ..robots.robot import base
from .model import ContactModel

if TYPE_CHECKING:
    from ..base.loops import Call
    from ..rows.site import Workspace


def bearing_calls(shared: Workspace) -> tuple[Call, ...]:
    """The loop that writes these forces where damped levels take them; none where nothing is damped or bears."""
    unknowns, n, rows = shared.unknowns, shared.n, base(shared.robot)
    contacts = [block.owner for block in unknowns.blocks if isinstance(block.owner, ContactModel)]
    if not (shared.aims and rows and contacts):
        return ()
    from ..base.loops import Call, Table
    from .kernels.bearing import write_bearing_forces

    forces = unknowns.n - n
    arms, told = list[Array](), list[Any]()
    for contact in contacts:
        first, own = unknowns.of(contact).start - n, corners_of(contact)
        arms.append(own)
        for i in range(len(own)):
            told += [contact.slot(shared).numbers, first + (0 if contact.wrench else 3 * i), contact.wrench]
            told.append(not contact.unilateral)
    points = sum(map(len, arms))
    places = Table(*(aim[n:] for aim in shared.aims))
    work = np.zeros(2 * rows * (1 + rows) + 3 * rows * points + forces)
    arrays = shared.blocks.bias(), shared.wrenches, points, Table(*told), np.concatenate(arms)
    return (Call(write_bearing_forces, n, rows, forces, *arrays, len(shared.aims), places, work),)


def corners_of(contact: ContactModel) -> Array:
    """Where its forces act from where they are taken, along t1 and t2, shape (points, 2) [m]: 0 but for a wrench."""
    if not contact.wrench:
        return np.zeros((len(contact.shape.points), 2))
    assert contact.lengths is not None
    corners: Array = 0.5 * contact.lengths * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
    return corners
