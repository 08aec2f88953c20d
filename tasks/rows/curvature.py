r"""The curvature of a task: the second derivatives of its value, which the linear rows leave out.

The rows say how the value moves, :math:`J \, dq`. After a step dq of all joints it is farther by
:math:`\tfrac12 dq^T H_i dq` in each row i. With a weight w for every row, a :class:`~tasks.rows.plan.Plan` gives the
sum :math:`S(w) = \sum_i w_i H_i`. With the error as weights it is the difference of Gauss-Newton's :math:`J^T J` and
the second derivative of half the squared error,

.. math:: \tfrac12 \lVert e(q \oplus dq) \rVert^2 = \tfrac12 \lVert e \rVert^2 - e^T J dq
    + \tfrac12 dq^T (J^T J - S(e)) dq + \dots,

and with multipliers for weights, on the directions which the rows leave free, it is the second-order change of the
value. Rows along axes that turn with the frame are taken so that both hold: a task with all its coordinates bends alike
along any axes. The target stands still.

Exact for positions, planes, the centre of mass, and at any error for a whole orientation or pose along the axes of the
world or of the frame, and for directions. Else up to the square of the error, and as far as the coordinates that a mask
leaves out are near their target.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..base.checks import Array
from ..robots.chain import Branched, carried, carried_in_tree, chain_order, joint_by_joint
from ..robots.kernels import block as at

if TYPE_CHECKING:
    from ..base.loops import Call, Entry, Table
    from .site import Site, Workspace


def curvature_call(site: Site, kernel: Any, seen: Table | None, size: int, *told: Entry) -> Call | None:
    """The call that adds S(w) of the rows of a part; None if the curvature of its frame is not known.

    Parameters
    ----------
    site : Site
    kernel : callable
        A loop of :mod:`tasks.frames.kernels.curvature`.
    seen : Table or None
        The curvature of the frame's motion.
    size : int
        Numbers of work space.
    *told : int, array or Table
        What the loop is told beside.
    """
    from ..base.loops import Call

    weights, total = np.zeros(site.rows), np.zeros((site.shared.n, site.shared.n))
    return None if seen is None else Call(kernel, weights, total, seen, np.zeros(size), *told)


def frame_curvature(shared: Workspace, name: str | None, relative_to: str | None = None) -> Table | None:
    """The curvature of the motion of a frame, for loops.

    None if the robot does not tell which joint carries which, or nobody will ask.
    """
    if not shared.curvature:
        return None
    places = chain_order(shared.robot, name)
    block = shared.blocks.frame(name)
    return _seen(shared, _of_block(shared, block, places), shared.blocks.frame(name, relative_to), relative_to)


def center_of_mass_curvature(shared: Workspace, relative_to: str | None = None) -> Table | None:
    """The curvature of the motion of the centre of mass; None where :func:`frame_curvature` gives none."""
    if not shared.curvature:
        return None
    axes, robot = shared.blocks.axes(), shared.robot
    tree = robot.tree_order() if isinstance(robot, Branched) else None
    if axes is None or tree is None:
        return None
    motion = _motion(shared.n, shared.blocks.center_of_mass(), axes[3:], (6, 1), carried_in_tree(tree))
    return _seen(shared, motion, shared.blocks.center_of_mass(relative_to), relative_to)


def _of_block(shared: Workspace, block: Array, places: NDArray[np.int64] | None) -> Table | None:
    """The curvature of the motion of a frame in the world, by its block."""
    if places is None:
        return None
    return _motion(shared.n, block, block[at.JACOBIAN + 3 * shared.n :], (1, shared.n), carried(places))


def _motion(n: int, block: Array, axes: Array, strides: tuple[int, int], pairs: NDArray[np.int64]) -> Table:
    """The table of a frame in the world, see :mod:`tasks.robots.kernels.curvature`."""
    from ..base.loops import Table

    chain, velocities = joint_by_joint(pairs)
    sums = np.zeros((len(chain) + 1, 6))
    return Table(n, block, axes, *strides, len(pairs), pairs, len(chain), chain, velocities, sums)


def _seen(shared: Workspace, motion: Table | None, block: Array, relative_to: str | None) -> Table | None:
    """The curvature of its motion relative to another frame, by its block in that frame."""
    from ..base.loops import Table

    if motion is None or relative_to is None:
        return None if motion is None else Table(motion, 0, block)
    root = _of_block(shared, shared.blocks.frame(relative_to), chain_order(shared.robot, relative_to))
    return None if root is None else Table(motion, root, block)
