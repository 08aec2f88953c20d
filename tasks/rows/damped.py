r"""A damped level that leaves its null space to the levels below.

A damped level minimises, within what the levels above it leave,

.. math:: \|D_k w_k\|^2 + \lambda^2 \|x\|^2,

is then frozen at what it reached, and the levels below have all of the null space of its rows: see
:mod:`hqp.damping.staged`. At velocity order x are the joint velocities, and the level changes them by at most its
missing part over :math:`2 \lambda`, for any posture: see :mod:`hqp.damping`. At acceleration order joints are damped
towards :math:`-2 \zeta K v`, and contact forces, where they are unknowns, towards those that bear the robot at rest
(:mod:`tasks.contacts.bearing`).

The rows of :class:`~tasks.joints.damping.Damping` beside a task ask for the same, and leave no null space: for a last
level they do the same in one solve.
"""

from __future__ import annotations

from hqp import DampingRule, InvalidInput
from hqp.damping import as_rule

from .part import Part, Stack


class Damped(Stack):
    """One level, damped by a rule: ``limits >> position >> Damped(orientation, 0.1) >> posture``.

    Where a level has a rule, a :class:`~tasks.Controller` damps no other one by default.

    Parameters
    ----------
    level : task, or several joined by +
    rule : float, DampingRule or None
        A number is the lambda of a :class:`hqp.FixedDamping`, in the unit of the weighted rows per unit of x: [m] or
        [1] for a task in [m] or [rad]. Else one of :class:`hqp.ManipulabilityDamping`,
        :class:`hqp.SingularValueDamping`, :class:`hqp.NumericalFiltering`, :class:`hqp.ErrorDamping`, whose bound is
        that of the joint velocities which the level adds, or a rule of your own. None: the level is left strict, while
        a controller damps the others by default.

    Raises
    ------
    InvalidInput
        If it is more than one level, is damped already, or the rule is none.

    Notes
    -----
    A damped level is one stage more, which the native solver takes in the same call; one more still where the rule
    looks at singular values or grows with the error, if the levels above ask for more than to stay within bounds that
    rest keeps. A lowest level is none. What its damping costs the level is told by ``step.relaxed``. ``solve_ik``,
    whose steps are bounded in a way of their own, takes the level and leaves its damping out.

    Examples
    --------
    >>> from tasks import Controller, Damped, OrientationTask, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> stack = PositionTask([1.0, 0.2], gain=2.0) >> Damped(OrientationTask(0.0, gain=2.0), 0.1)
    >>> Controller(arm, stack)(q).v.round(3)
    array([ 1.456, -2.211,  2.462])
    """

    def __init__(self, level: Part | Stack, rule: DampingRule | float | None) -> None:
        super().__init__(level)
        if len(self) != 1:
            raise InvalidInput(f"Damped takes one level, but {level!r} has {len(self)}; damp each by itself")
        if self.damping[0] is not None:
            raise InvalidInput(f"{level!r} is damped already; a level takes one rule")
        self.damping = (False if rule is None else as_rule(rule, f"Damped({level!r}): rule"),)
