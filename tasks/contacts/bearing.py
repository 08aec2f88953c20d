r"""The forces that bear a robot at rest: what levels that are damped pull contact forces towards.

Damped towards no force, a level would hold its robot up less. At every tick forces are pulled towards the least ones
that meet the rows of the base at :math:`a = 0`, :math:`G_u^T f = b_u`. These hang on the state, and on which contacts
are on, alone: nothing is remembered, so the same state has the same answer. Friction and the sign of normal forces are
not regarded: they are least squares, of which the solver takes what is inside the cones.

Each force at a point counts the same. A wrench counts as the forces at the corners of its rectangle that give it, so
that both kinds of a contact bear the same. A contact that is being made or released takes the share of its ramp.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

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

    count = unknowns.n - n
    ease, told = np.zeros(count), []
    for contact in contacts:
        own = unknowns.of(contact)
        ease[own.start - n : own.stop - n] = ease_of(contact)
        told += [contact.slot(shared).numbers, own.start - n, own.stop - own.start]
    places = Table(*(aim[n:] for aim in shared.aims))
    work = np.zeros(count + rows * (1 + 2 * rows))
    arrays = shared.blocks.bias(), shared.wrenches, ease, len(contacts), Table(*told), len(shared.aims), places, work
    return (Call(write_bearing_forces, n, rows, count, *arrays),)


def ease_of(contact: ContactModel) -> Array:
    """How much each of its forces bears: 1 at a point; of a wrench, 4 for forces and [m^2] for moments."""
    if not contact.wrench:
        return np.ones(contact.unknowns)
    assert contact.lengths is not None
    x, y = contact.lengths
    return np.array([4.0, 4.0, 4.0, y * y, x * x, x * x + y * y])
