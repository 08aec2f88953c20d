r"""A contact: the motion that it constrains, and the forces that it exerts on the robot.

With the contact's forces f on the robot along the axes of its surface, (t1, t2, n) at each point, a contact stands for

=================  ===================================  ==================================================
force bounds       :math:`0 \le f_n \le` cap            above all levels; all forces 0 where it is off
contact motion     :math:`J_c a = -\dot J_c v + \dots`  where the contact stands, or, if it may slip, below the limits
friction           :math:`(d_i - \mu \cos(\pi / m) n)^T f \le 0`  with the first limits from its own level on
=================  ===================================  ==================================================

Friction is a pyramid of m faces inside the cone: no force that it allows slips. Forces need :class:`tasks.Dynamics` in
the stack; without, and at velocity order, a contact is its motion alone.
"""

from __future__ import annotations

from hqp import InvalidInput

from ..rows.expansion import Companions, Setting
from ..rows.part import Part
from .forces import ForceBounds
from .friction import Friction
from .model import ContactModel
from .motion import ContactMotion


class Contact(ContactModel):
    """A frame that touches the world, at points, along a line or on a rectangle.

    Parameters
    ----------
    frame : str
    points : array, shape (k, 3), optional
        Where it touches [m], in the coordinates of the frame.
    plane : array, shape (2,), optional
        Lengths of a rectangle along x and y of the frame [m], in its place: forces act at its corners.
    line : float, optional
        Length along x of the frame [m], in its place. Without any of them it is a point.
    centre : array, shape (3,)
        Where these are counted from, in the coordinates of the frame [m].
    friction : float, optional
        mu, positive; needed where the contact is unilateral and the stack has forces.
    normal : array, shape (3,)
        The direction in which the surface pushes, in the axes of the world or of `surface`.
    surface : Surface, optional
        What it touches, if that moves or is turned.
    name : str, optional
        Default: the frame.
    unilateral : bool
        Whether it only pushes, with friction; else it holds fast, like a hand that grips.
    faces : int
        Of the pyramid of friction, at least 3; the more, the nearer to the cone.
    wrench : bool
        Whether its unknowns are one force and one moment at the centre, and not a force at every point; for a `plane`.
    torsion : float, optional
        The largest moment about the normal by the normal force [m], of a wrench (default: mu times a quarter of the sum
        of both lengths).
    least, largest : float
        Of the sum of the normal forces [N].
    gain, damping_ratio : float
        K [1/s] and zeta by which the contact goes back where it has moved; see :class:`tasks.Task`.
    weight : float
        Of its motion inside the level.
    may_slip : bool
        Whether its motion stands below the limits: it slips rather than that a limit is passed.

    Raises
    ------
    InvalidInput
        If a number or the points are wrong; with a robot, if there is no such frame.

    Examples
    --------
    >>> from tasks import Contact, Dynamics, ForceTask
    >>> foot = Contact("left_ankle_roll_link", plane=(0.2, 0.1), friction=0.6, name="left foot")
    >>> Dynamics() + foot >> ForceTask(weight=1e-2)
    Dynamics() + Contact('left_ankle_roll_link', friction=0.6, name='left foot') >> ForceTask(weight=0.01)
    """

    def companions(self, setting: Setting) -> Companions:
        motion = (ContactMotion(self),)
        here, below = ((), motion) if self.may_slip else (motion, ())
        if setting.order != "acceleration" or not setting.has_dynamics:
            return Companions(here, below=below)
        limits: tuple[Part, ...] = ()
        if self.unilateral:
            if self.friction is None:
                raise InvalidInput(
                    f"{self.full_name()}: needs its friction, as in Contact({self.frame!r}, friction=0.6)"
                )
            limits = (Friction(self),)
        return Companions(here, top=(ForceBounds(self),), limits=limits, below=below, block=self.block())
