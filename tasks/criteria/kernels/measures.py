"""Measures of a task's Jacobian, with their gradients in closed form."""

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

#: Of both measures, after what the law is told (:mod:`.joints`): joints; the block of the frame; the axes; what the
#: rows read of it; how many they are; the order of the chain; work space, and its size; the gradient.
N, BLOCK, AXES, READING, ROWS, CHAIN, WORK, WORK_SIZE, SLOPE = range(CLIMB, CLIMB + 9)
#: Of the velocity ratio: the direction, or the velocity of the target (6,); which of the two.
ALONG, DESIRED = range(CLIMB + 9, CLIMB + 11)
#: As :data:`tasks.criteria.manipulability.SHORTEST`.
SHORTEST = 1e-150


def work_size(n: int, rows: int) -> int:
    """Numbers of work space that a measure takes."""
    return 19 * n + rows * (n + rows + 3) + 24


@inner
def svd(frame, n, axes, reading, rows, work):
    """The singular values of what a task reads of a frame, with G at the beginning of work; see :func:`decompose`."""
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

    With :math:`J = \sum_k \sigma_k u_k v_k^T` the sensitivity to J is :math:`w (J^\#)^T`, which is
    :math:`\sum_k (w / \sigma_k) u_k v_k^T`. Where J loses rank w has an edge, as the norm of a vector has at 0: on all
    sides it rises, and the gradient is 0, as that of a balanced difference.

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
    r"""The least singular value :math:`\sigma_m`, and its gradient, by the sensitivity :math:`u_m v_m^T` to J.

    Where J has lost rank it has an edge, and the gradient is 0, as that of :func:`manipulability`. Where two are the
    least it is that of one of them.

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
    r"""The velocity ratio in the direction u, and its gradient.

    With the pseudoinverse of J, :math:`z = J^\# u`, :math:`y = (J J^T)^\# u` and :math:`s = \lVert z \rVert^2`

    .. math:: r = \frac{\lVert u \rVert}{\sqrt s}, \qquad \frac{\partial r}{\partial J} = \frac r s \, y z^T, \qquad
        \frac{\partial r}{\partial u} = \frac{r}{\lVert u \rVert^2} u - \frac r s y .

    Directions that J has lost do not count where u has no part along them; else r is 0, and so is the gradient, as of
    :func:`manipulability`.

    Parameters
    ----------
    frame, n, axes, reading, rows, order, slope
        See :func:`manipulability`.
    u : (rows,)
        Of any length; nothing is asked where it is 0.
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
    r"""The same along the velocity of the target, which its own axes see turn with the robot.

    With the desired velocity :math:`\dot p, \omega` in the axes of the world, its coordinates in the axes of the frame
    change by :math:`-\omega_i \times \dot p, -\omega_i \times \omega`; and those of the point that is passing the
    origin by :math:`l_i \times \omega`, l being that of the frame.

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
    """Climb the manipulability of a task."""
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
    """Climb the minor axis of the velocity ellipsoid of a task."""
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
    """Climb the velocity ratio of a task, along a direction or along its own desired velocity."""
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
