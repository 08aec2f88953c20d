"""Measures of a task's Jacobian (manipulability, minor axis, velocity ratio), with their gradients in closed form."""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import decompose, fill
from ...base.rank import RANK_TOLERANCE
from ...frames.kernels.placement import LOCAL, WORLD, along
from ...robots.kernels.block import JACOBIAN
from .gradient import add_outer, gradient, jacobian
from .joints import CLIMB, climb

#: Table of all measures, after the entries of every gradient (:mod:`.joints`): joints; block of the frame; the axes;
#: the coefficients of the rows, number of rows; the order of the chain; work space, and its size; the gradient.
N, BLOCK, AXES, READING, ROWS, CHAIN, WORK, WORK_SIZE, SLOPE = range(CLIMB, CLIMB + 9)
#: Of the velocity ratio, after that: the direction (rows,) or the velocity of the target (6,); if it is the latter.
ALONG, DESIRED = range(CLIMB + 9, CLIMB + 11)
#: As :data:`tasks.criteria.manipulability.SHORTEST`.
SHORTEST = 1e-150


def work_size(n: int, rows: int) -> int:
    """The size of the work space of a measure."""
    return 19 * n + rows * (n + rows + 3) + 24


@inner
def svd(frame, n, axes, reading, rows, work):
    """Decompose the Jacobian of a task: returns rows, left singular vectors, singular values, as :func:`decompose`.

    G of :func:`.gradient.jacobian` is then in work[:6 * n].
    """
    first = 18 * n
    second = first + rows * n
    third = second + rows * rows
    J, ways, sizes = work[first:second], work[second:third], work[third : third + rows]
    jacobian(frame, n, axes, reading, rows, work[: 6 * n], J, work[third + rows :])
    decompose(J, rows, n, ways, sizes)
    return J, ways, sizes


@inner
def manipulability(frame, n, axes, reading, rows, order, slope, work):
    r"""Yoshikawa's measure :math:`w = \sigma_1 \cdots \sigma_m`, and its gradient.

    With :math:`J = \sum_k \sigma_k u_k v_k^T`, the derivative by J is :math:`w (J^\#)^T = \sum_k (w / \sigma_k) u_k
    v_k^T`. Where J loses rank, w has a kink, like the norm of a vector at 0: it rises on both sides, and the gradient
    returned is 0, as a central difference gives.

    Parameters
    ----------
    frame : (26 + 6 * n,)
        See :mod:`tasks.robots.kernels.block`.
    axes : int
        WORLD, LOCAL or SPATIAL.
    reading : (rows * 6,)
        See :func:`tasks.criteria.kernels.gradient.jacobian`.
    order : int (n,)
        See :func:`tasks.criteria.kernels.gradient.gradient`.
    slope : (n,)
        On return the gradient [unit of w per rad, or per m].
    work : (work_size(n, rows),)

    Returns
    -------
    w : float
    """
    G, C, own = work[: 6 * n], work[6 * n : 12 * n], work[12 * n : 18 * n]
    J, ways, sizes = svd(frame, n, axes, reading, rows, work)
    measure = 1.0 if rows <= n else 0.0
    for k in range(rows):
        measure *= sizes[k]
    fill(slope, n, 0.0 * measure)  # NaN where it is
    if rows > n or sizes[rows - 1] <= RANK_TOLERANCE * sizes[0] or measure != measure:
        return measure
    fill(C, 6 * n, 0.0)
    for k in range(rows):
        share = measure / sizes[k] / sizes[k]
        add_outer(C, n, reading, rows, ways[k * rows : (k + 1) * rows], J[k * n : (k + 1) * n], share)
    gradient(G, C, n, axes, order, slope, own)
    return measure


@inner
def minor_axis(frame, n, axes, reading, rows, order, slope, work):
    r"""The smallest singular value :math:`\sigma_m`, and its gradient, from its derivative by J, :math:`u_m v_m^T`.

    Where J has lost rank it has a kink, and the gradient is 0, as for :func:`manipulability`. If two singular values
    are smallest, it is the gradient of one of them.

    Parameters
    ----------
    frame, n, axes, reading, rows, order, slope, work
        See :func:`manipulability`.

    Returns
    -------
    sigma : float
    """
    G, C, own = work[: 6 * n], work[6 * n : 12 * n], work[12 * n : 18 * n]
    J, ways, sizes = svd(frame, n, axes, reading, rows, work)
    last = rows - 1
    measure = sizes[last] if rows <= n else 0.0
    fill(slope, n, 0.0 * measure)  # NaN where it is
    if rows > n or measure <= RANK_TOLERANCE * sizes[0] or measure != measure:
        return measure
    fill(C, 6 * n, 0.0)
    add_outer(C, n, reading, rows, ways[last * rows : rows * rows], J[last * n : rows * n], 1.0 / measure)
    gradient(G, C, n, axes, order, slope, own)
    return measure


@inner
def velocity_ratio(frame, n, axes, reading, rows, order, u, slope, pull, work):
    r"""The velocity ratio r in the direction u, and its gradient.

    With :math:`z = J^\# u`, :math:`y = (J J^T)^\# u` and :math:`s = \lVert z \rVert^2`,

    .. math:: r = \frac{\lVert u \rVert}{\sqrt s}, \qquad \frac{\partial r}{\partial J} = \frac r s \, y z^T, \qquad
        \frac{\partial r}{\partial u} = \frac{r}{\lVert u \rVert^2} u - \frac r s y .

    If u has a part along a direction that J has lost, r is 0 up to round-off, and the gradient is 0, as for
    :func:`manipulability`. Otherwise lost directions do not count.

    Parameters
    ----------
    frame, n, axes, reading, rows, order, slope
        See :func:`manipulability`.
    u : (rows,)
        Of any length; if it is 0, r and the gradient are 0.
    pull : (rows,)
        On return dr/du.
    work : (work_size(n, rows),)

    Returns
    -------
    r : float
    """
    G, C, own = work[: 6 * n], work[6 * n : 12 * n], work[12 * n : 18 * n]
    J, ways, sizes = svd(frame, n, axes, reading, rows, work)
    first = 18 * n + rows * (n + rows + 1) + 12
    z = work[first : first + n]
    square = whole = s = 0.0
    for r in range(rows):
        square += u[r] * u[r]
    fill(z, n, 0.0)
    fill(pull, rows, 0.0)
    fill(slope, n, 0.0)
    if square == 0.0:
        return 0.0
    lost = False
    for k in range(rows):
        part, size = 0.0, sizes[k]
        for r in range(rows):
            part += ways[k * rows + r] * u[r]
        whole += (part / max(size, SHORTEST)) ** 2
        if size <= RANK_TOLERANCE * sizes[0]:
            lost = lost or abs(part) > RANK_TOLERANCE * math.sqrt(square)
            continue
        s += (part / size) ** 2
        for j in range(n):
            z[j] += part / size / size * J[k * n + j]
        for r in range(rows):
            pull[r] += part / size / size * ways[k * rows + r]
    ratio = math.sqrt(square / whole)
    if lost or ratio != ratio:
        fill(pull, rows, 0.0 * ratio)
        fill(slope, n, 0.0 * ratio)
        return ratio
    share = math.sqrt(square / s) / s
    fill(C, 6 * n, 0.0)
    add_outer(C, n, reading, rows, pull, z, share)
    gradient(G, C, n, axes, order, slope, own)
    for r in range(rows):
        pull[r] = ratio / square * u[r] - share * pull[r]
    return ratio


@inner
def desired_velocity_ratio(frame, n, axes, reading, rows, order, desired, slope, work):
    r"""The velocity ratio along the desired velocity of the target, and its gradient.

    The direction u depends on the joints, too, as the axes of the task move. With the desired velocity
    :math:`\dot p, \omega` along the axes of the world, its coordinates along the axes of the frame change by
    :math:`-\omega_i \times \dot p, -\omega_i \times \omega` with joint i; those of the point at the origin of the world
    (spatial rows) by :math:`l_i \times \omega`, with :math:`l_i` of the frame.

    Parameters
    ----------
    frame, n, axes, reading, rows, order, slope
        See :func:`manipulability`.
    desired : (6,)
        Linear and angular, in the axes of the world.
    work : (work_size(n, rows),)

    Returns
    -------
    r : float
    """
    first = 19 * n + rows * (n + rows + 1) + 12
    u, pull, seen, force = (
        work[first : first + rows],
        work[first + rows : first + 2 * rows],
        work[first + 2 * rows : first + 2 * rows + 6],
        work[first + 2 * rows + 6 : first + 2 * rows + 12],
    )
    along(axes, frame, desired, 0, seen, 0)
    for r in range(rows):
        u[r] = 0.0
        for k in range(6):
            u[r] += reading[6 * r + k] * seen[k]
    ratio = velocity_ratio(frame, n, axes, reading, rows, order, u, slope, pull, work)
    if axes == WORLD:
        return ratio
    for k in range(6):  # dr / d seen
        force[k] = 0.0
        for r in range(rows):
            force[k] += reading[6 * r + k] * pull[r]
    x, y, z, a, b, c = seen[0], seen[1], seen[2], seen[3], seen[4], seen[5]
    u0, u1, u2, u3, u4, u5 = force[0], force[1], force[2], force[3], force[4], force[5]
    if axes == LOCAL:  # force . (-omega_i x seen)
        first, m0 = 3 * n, -(y * u2 - z * u1 + b * u5 - c * u4)
        m1, m2 = -(z * u0 - x * u2 + c * u3 - a * u5), -(x * u1 - y * u0 + a * u4 - b * u3)
        G = work
    else:  # force . (l_i x omega)
        first, m0, m1, m2 = JACOBIAN, b * u2 - c * u1, c * u0 - a * u2, a * u1 - b * u0
        G = frame
    for i in range(n):
        if order[i] >= 0:
            slope[i] += m0 * G[first + i] + m1 * G[first + n + i] + m2 * G[first + 2 * n + i]
    return ratio


@stamp
@entry
def write_manipulability(here):
    """Write the rows that increase, or decrease, the manipulability of a task."""
    told = ints(here, 0, ALONG)
    n, rows = told[N], told[ROWS]
    frame, reading, order = (
        floats(told[BLOCK], 0, JACOBIAN + 6 * n),
        floats(told[READING], 0, 6 * rows),
        ints(told[CHAIN], 0, n),
    )
    work, slope = floats(told[WORK], 0, told[WORK_SIZE]), floats(told[SLOPE], 0, n)
    manipulability(frame, n, told[AXES], reading, rows, order, slope, work)
    climb(here, slope)
    return 0


@stamp
@entry
def write_minor_axis(here):
    """Write the rows that increase, or decrease, the minor axis of the velocity ellipsoid of a task."""
    told = ints(here, 0, ALONG)
    n, rows = told[N], told[ROWS]
    frame, reading, order = (
        floats(told[BLOCK], 0, JACOBIAN + 6 * n),
        floats(told[READING], 0, 6 * rows),
        ints(told[CHAIN], 0, n),
    )
    work, slope = floats(told[WORK], 0, told[WORK_SIZE]), floats(told[SLOPE], 0, n)
    minor_axis(frame, n, told[AXES], reading, rows, order, slope, work)
    climb(here, slope)
    return 0


@stamp
@entry
def write_velocity_ratio(here):
    """Write the rows that increase, or decrease, the velocity ratio, along a direction or the desired velocity."""
    told = ints(here, 0, DESIRED + 1)
    n, rows = told[N], told[ROWS]
    frame, reading, order = (
        floats(told[BLOCK], 0, JACOBIAN + 6 * n),
        floats(told[READING], 0, 6 * rows),
        ints(told[CHAIN], 0, n),
    )
    work, slope = floats(told[WORK], 0, told[WORK_SIZE]), floats(told[SLOPE], 0, n)
    if told[DESIRED] != 0:
        desired = floats(told[ALONG], 0, 6)
        desired_velocity_ratio(frame, n, told[AXES], reading, rows, order, desired, slope, work)
    else:
        u, pull = floats(told[ALONG], 0, rows), work[19 * n + rows * (n + rows + 2) + 12 :]
        velocity_ratio(frame, n, told[AXES], reading, rows, order, u, slope, pull, work)
    climb(here, slope)
    return 0
