r"""A contact: the motion that it constrains, and the forces that it exerts on the robot.

With f the contact forces on the robot, (t1, t2, n) along the axes of the surface at each point, a contact adds these
rows:

=================  ===================================  ==================================================
force bounds       :math:`0 \le f_n \le` cap            above all levels; all forces 0 where it is off
contact motion     :math:`J_c a = -\dot J_c v + \dots`  where the contact stands, or, if it may slip, below the limits
friction           :math:`(d_i - \mu \cos(\pi / m) n)^T f \le 0`  with the first limits at its own level or below
=================  ===================================  ==================================================

Friction is a pyramid of m faces inside the friction cone, so that no force it allows slips. Forces need
:class:`tasks.Dynamics` in the stack; without it, and at velocity order, a contact constrains the motion alone.
"""

from __future__ import annotations

from hqp import InvalidInput

from ..robots.robot import base
from ..rows.expansion import Companions, Setting
from ..rows.part import Part
from .forces import ForceBounds
from .friction import Friction
from .model import ContactModel
from .motion import ContactMotion

#: Velocities of a base that moves in the plane.
PLANAR = 3
#: A normal counts as upright from this height of its unit vector on.
UPRIGHT = 1.0 - 1e-6


class Contact(ContactModel):
    """A frame that touches the world, at points, along a line or on a rectangle.

    Parameters
    ----------
    frame : str
    points : array, shape (k, 3), optional
        Where it touches [m], in the coordinates of the frame.
    plane : array, shape (2,), optional
        Instead of `points`: lengths of a rectangle along x and y of the frame [m]; forces act at its corners.
    line : float, optional
        Instead of `points`: length of a line along x of the frame [m]. Without any of these the contact is a point.
    radius : float, optional
        Instead of `points`: of a ball, or a wheel that stands upright, about `centre`, which rolls on the world without
        slip [m]. It touches at its lowest point along the normal, whichever that is.
    centre : array, shape (3,)
        Origin of the points, rectangle or line, in the coordinates of the frame [m].
    friction : float, optional
        mu, positive; required if the contact is unilateral and the stack has forces.
    normal : array, shape (3,)
        Direction in which the surface pushes on the robot, in the axes of the world, or of `surface` if given.
    surface : Surface, optional
        The body that it touches, if that body moves or is rotated.
    name : str, optional
        Default: the frame.
    unilateral : bool
        Whether the contact can only push, with friction; if False it also pulls, like a hand that grips.
    faces : int
        Number of faces of the friction pyramid, at least 3; more faces are closer to the cone.
    wrench : bool
        Whether the unknowns are one force and one moment at the centre, not a force at every point; needs `plane`.
    torsion : float, optional
        With `wrench`: largest moment about the normal, divided by the normal force [m] (default: mu times a quarter of
        the sum of both lengths).
    least, largest : float
        Bounds of the sum of the normal forces [N].
    gain, damping_ratio : float
        K [1/s] and zeta with which the contact returns to its place after it has moved; see :class:`tasks.Task`.
    weight : float
        Weight of its motion inside the level.
    may_slip : bool
        Whether its motion has lower priority than the limits: the contact slips before a limit is violated.

    Raises
    ------
    InvalidInput
        If a number or the points are invalid, or something that rolls is given points or a surface; with a robot, if it
        has no such frame, or its base moves in the plane and it would stand on a contact with forces.

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
            if base(setting.robot) == PLANAR and self.surface is None and abs(self.normal[2]) > UPRIGHT:
                raise InvalidInput(
                    f"{self.full_name()}: its friction hangs on the weight of {setting.robot!r}, which a base in the"
                    " plane does not tell; load it with base='floating'"
                )
            limits = (Friction(self),)
        return Companions(here, top=(ForceBounds(self),), limits=limits, below=below, block=self.block())
