r"""Damped least squares as rows: small x as a competing task on the same level.

Beside a task :math:`J x = h` on the same level, rows :math:`\lambda (x - r) = 0` make that level minimise

.. math:: \lVert J x - h \rVert^2 + \lambda^2 \lVert x - r \rVert^2,

the damped least squares of Wampler (1986) and of Nakamura and Hanafusa (1986), within what the levels
above leave. Where the task goes out of reach the exact answer jumps, and limits on top make it
bang-bang; the damped answer does not jump; its price is a small error of its own task only.

At velocity order r = 0. At acceleration order that would let the joints coast: their speeds would stay, and
in weak directions of the task they would keep swinging. So there :math:`r = -2 \zeta K \dot q`, by the law
:math:`J \ddot q = \ddot r^d - \dot J \dot q + 2 \zeta K \dot e + K^2 e` of the task: along a singular direction of
value :math:`\sigma`, and for a target at rest,

.. math:: \ddot q = \frac{\sigma}{\sigma^2 + \lambda^2} K^2 e - 2 \zeta K \dot q .

All speeds are braked at one rate, for any :math:`\lambda`, and only the stiffness is smaller: the damping ratio is
:math:`\zeta \sqrt{1 + \lambda^2 / \sigma^2}`, never below that of the task. With several tasks the fastest one
counts; with none, r = 0.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from hqp.checks import of_type

from ..rows.part import Part

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site


class Damping(Part):
    """Damped least squares: rows ``x = 0`` in every joint, joined to a task by ``+``.

    At acceleration order they are ``x = -2 zeta K v``, by the gain K of the task: speeds are braked, nothing swings.

    ``OrientationTask(0.0, gain=2.0) + Damping(0.1)`` damps the orientation and nothing above it. The
    rows leave no null space, so that nothing below them can be met: damp the last level.

    Parameters
    ----------
    weight : float or array, shape (nv,)
        The lambda, against tasks of weight 1: [m] or [1], for a task in [m] or [rad]; 0 for a joint that is not damped.
    name : str, optional

    Raises
    ------
    InvalidInput
        If a weight is negative or larger than 1e15.

    Examples
    --------
    >>> from tasks import Controller, Damping, PlanarArm, PositionTask
    >>> arm = PlanarArm([0.5, 0.5, 0.5])
    >>> q = [1.1, -1.3, -0.7]
    >>> Controller(arm, PositionTask([1.0, 0.2], gain=2.0) + Damping(0.1))(q).v.round(3)
    array([ 0.526,  0.001, -0.18 ])
    """

    plain = True
    rows = None
    damps = True

    def __init__(self, weight: ArrayLike, *, name: str | None = None) -> None:
        self.name = "damping" if name is None else of_type(name, str, "name of a Damping")
        self.weight = weight

    def plan(self, site: Site) -> Plan:
        """The bounds; the rows are those of the identity from the start."""
        from ..base.loops import Call
        from ..rows.kernels.braking import write_damping
        from ..rows.plan import Plan

        return Plan((Call(write_damping, site.rows, site.rate, site.shared.v, site.lower, site.upper),), linear=True)

    def __repr__(self) -> str:
        return f"Damping({self.weight.tolist()})"
