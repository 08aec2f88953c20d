r"""Damped least squares as rows: small x as a competing task on the same level.

Beside a task :math:`J x = h` on the same level, rows :math:`\lambda x = 0` make that level minimise

.. math:: \lVert J x - h \rVert^2 + \lambda^2 \lVert x \rVert^2,

the damped least squares of Wampler (1986) and of Nakamura and Hanafusa (1986), within what the levels
above leave. Where the task goes out of reach the exact answer jumps, and limits on top make it
bang-bang; the damped one does not jump, and pays with a small error of its own task only.

At acceleration order x are the accelerations: what is damped is their size, and a speed that is there stays. Joints may
swing on, past the loss of reach. What brakes them is :class:`tasks.MinimumMotionTask` in its place, whose rows ask for
:math:`\lambda (\ddot q + K \dot q) = 0`.
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
    """

    plain = True
    rows = None

    def __init__(self, weight: ArrayLike, *, name: str | None = None) -> None:
        self.name = "damping" if name is None else of_type(name, str, "name of a Damping")
        self.weight = weight

    def plan(self, site: Site) -> Plan:
        """The bounds; the rows are those of the identity from the start."""
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.joints import write_rest

        return Plan((Call(write_rest, site.rows, site.lower, site.upper),))

    def __repr__(self) -> str:
        return f"Damping({self.weight.tolist()})"
