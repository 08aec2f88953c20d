"""The motion that a contact constrains: its centre stays in place on the surface, and its frame does not turn there.

What rolls touches with another point at every moment: that one has no velocity, and no place to go back to.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hqp import InvalidInput

from ..base.checks import Array
from ..base.live import structure
from ..robots.robot import Robot, check_frame
from ..rows.loop_task import LoopTask
from ..rows.part import Order

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site
    from .model import ContactModel

#: Names of the motions along and about the axes of the surface.
LINEAR, ANGULAR = ("t1", "t2", "normal"), ("about t1", "about t2", "about the normal")


class ContactMotion(LoopTask):
    """Rows :math:`J_c x` of a contact, by the law of a task; without bounds while the contact is off.

    Parameters
    ----------
    contact : Contact
        The contact whose gain, damping ratio and weight are used.
    """

    contact: ContactModel = structure()

    def __init__(self, contact: ContactModel) -> None:
        self.contact, self.name, self.rows = contact, contact.name, contact.shape.motions

    cap: Array | None = structure(None)
    deceleration: float | None = structure(None)

    if not TYPE_CHECKING:  # live numbers are those of the contact

        @property
        def gain(self) -> Array:
            return np.asarray(self.contact.gain)

        @property
        def damping_ratio(self) -> float:
            return self.contact.damping_ratio

        @property
        def weight(self) -> Array:
            return self.contact.weight

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        check_frame(robot, self.contact.frame, f"{self.contact.full_name()}: frame")
        frame = self.at_rest(robot).frame(self.contact.frame)
        if frame.rotation.ndim == 1:
            raise InvalidInput(
                f"{self.contact.full_name()}: {robot!r} moves in the plane; contacts take robots in space"
            )
        if not (np.any(frame.linear) or np.any(frame.angular)):
            raise InvalidInput(
                f"{self.contact.full_name()}: no joint of {robot!r} moves it; its forces would do nothing"
            )
        self.check_gain(order, dt)

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        turning = self.contact.shape.turning.tolist()
        return [(name, "m") for name in LINEAR] + [(ANGULAR[k], "rad") for k in turning]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.contact import write_contact_motion
        from .mapping import keep_map

        shared, shape = site.shared, self.contact.shape
        slot, block = self.contact.slot(shared), site.frame(self.contact.frame)
        moves = keep_map(self.contact, shared)
        if self.contact not in shared.unknowns:  # with forces, their bounds advance the slot
            moves = (*moves, slot.move)
        rolls = self.contact.radius is not None
        centre = self.contact.touching(shared) if rolls else shape.centre
        told: list[Any] = [site.law(self), slot.numbers, block, centre, slot.surface, slot.axes]
        return Plan((Call(write_contact_motion, *told, len(shape.turning), shape.along, shared.work, rolls),), moves)

    def __repr__(self) -> str:
        return f"motion of {self.contact!r}"
