r"""Secondary criteria as loops: measures of a task's Jacobian with their gradients in closed form, and least motion.

**How the Jacobian of a frame changes.** With the columns :math:`l_j, \omega_j` of joint j in the axes of the world, and
:math:`i \preceq j` if joint i comes before j in the chain or is that joint: i then carries j along, and turns its
column; else it moves the frame away from the axis of j,

.. math::

    \frac{\partial l_j}{\partial q_i} = \begin{cases} \omega_i \times l_j & i \preceq j \\
        \omega_j \times l_i & \text{else,} \end{cases} \qquad
    \frac{\partial \omega_j}{\partial q_i} = \begin{cases} \omega_i \times \omega_j & i \preceq j \\
        0 & \text{else.} \end{cases}

**A gradient** of a scalar of J is the sum of these, weighed by the sensitivities
:math:`C^l_j = \partial H / \partial l_j`, :math:`C^\omega_j = \partial H / \partial \omega_j`. With
:math:`m_j = l_j \times C^l_j + \omega_j \times C^\omega_j` and :math:`s_j = C^l_j \times \omega_j`

.. math:: \frac{\partial H}{\partial q_i} = \omega_i \cdot \sum_{i \preceq j} m_j + l_i \cdot \sum_{i \not\preceq j} s_j .

In the axes of the frame itself, which turn with it, :math:`\omega_i \cdot \sum_j m_j` is taken off, all columns now in
these axes; and :math:`l_i \cdot \sum_j s_j` where l is the velocity of the point that is passing the origin.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import inner

from ..kernels.algebra import RANK_TOLERANCE, decompose, fill, root
from ..robots.block import JACOBIAN, POSITION, ROTATION

#: The axes of a task: those of the world, those of the frame, or of the world with the linear rows those of the point
#: that is passing its origin.
WORLD, LOCAL, SPATIAL = range(3)
#: As :data:`tasks.criteria.manipulability.SHORTEST`.
SHORTEST = 1e-150


@inner
def along(frame, axes, x, y, z, a, b, c, out, first, step):
    """A velocity, linear (x, y, z) and angular (a, b, c), in the axes of a task: six numbers of out, `step` apart."""
    if axes == LOCAL:
        for k in range(3):
            r0, r1, r2 = frame[ROTATION + k], frame[ROTATION + 3 + k], frame[ROTATION + 6 + k]
            out[first + k * step] = r0 * x + r1 * y + r2 * z
            out[first + (3 + k) * step] = r0 * a + r1 * b + r2 * c
        return
    if axes == SPATIAL:
        p0, p1, p2 = frame[POSITION], frame[POSITION + 1], frame[POSITION + 2]
        x, y, z = x + p1 * c - p2 * b, y + p2 * a - p0 * c, z + p0 * b - p1 * a
    out[first], out[first + step], out[first + 2 * step] = x, y, z
    out[first + 3 * step], out[first + 4 * step], out[first + 5 * step] = a, b, c


@inner
def jacobian(frame, n, axes, reading, rows, G, J):
    """The columns of a frame in the axes of a task, G (6 * n,), and what the task reads of them, J (rows * n,).

    Parameters
    ----------
    reading : (rows * 6,)
        What each row takes of the linear and angular velocity in these axes: of a mask, one 1.0 a row.
    """
    at = JACOBIAN
    for j in range(n):
        k = at + j
        x, y, z, a, b, c = frame[k], frame[k + n], frame[k + 2 * n], frame[k + 3 * n], frame[k + 4 * n], frame[k + 5 * n]
        along(frame, axes, x, y, z, a, b, c, G, j, n)
    fill(J, rows * n, 0.0)
    for r in range(rows):
        row = J[r * n : (r + 1) * n]
        for k in range(6):
            share, column = reading[6 * r + k], G[k * n : (k + 1) * n]
            if share != 0.0:
                for j in range(n):
                    row[j] += share * column[j]


@inner
def add_outer(C, n, reading, rows, y, z, scale):
    """Add ``scale * reading^T y z^T`` to C (6 * n,), for y (rows,) and z (n,)."""
    for k in range(6):
        share, row = 0.0, C[k * n : (k + 1) * n]
        for r in range(rows):
            share += reading[6 * r + k] * y[r]
        share *= scale
        for j in range(n):
            row[j] += share * z[j]


@inner
def gradient(G, C, n, axes, order, slope, work):
    """The gradient of a scalar, slope (n,), from its sensitivities C to the columns G: see the module's docstring.

    Parameters
    ----------
    G, C : (6 * n,)
        In the axes of the task.
    order : int (n,)
        The place of each joint in the chain that carries the frame, joints that move as one having the same; -1 where a
        joint does not move the frame.
    work : (6 * n,)
    """
    m0, m1, m2, s0, s1, s2 = (
        work[:n],
        work[n : 2 * n],
        work[2 * n : 3 * n],
        work[3 * n : 4 * n],
        work[4 * n : 5 * n],
        work[5 * n : 6 * n],
    )
    for j in range(n):
        x, y, z, a, b, c = G[j], G[j + n], G[j + 2 * n], G[j + 3 * n], G[j + 4 * n], G[j + 5 * n]
        u, v, w, d, e, f = C[j], C[j + n], C[j + 2 * n], C[j + 3 * n], C[j + 4 * n], C[j + 5 * n]
        m0[j], m1[j], m2[j] = y * w - z * v + b * f - c * e, z * u - x * w + c * d - a * f, x * v - y * u + a * e - b * d
        s0[j], s1[j], s2[j] = v * c - w * b, w * a - u * c, u * b - v * a
    for i in range(n):
        slope[i] = 0.0
        if order[i] < 0:
            continue
        a0 = a1 = a2 = b0 = b1 = b2 = 0.0
        for j in range(n):
            if order[j] >= order[i]:
                if axes != LOCAL:
                    a0, a1, a2 = a0 + m0[j], a1 + m1[j], a2 + m2[j]
                if axes == SPATIAL:
                    b0, b1, b2 = b0 - s0[j], b1 - s1[j], b2 - s2[j]
            elif order[j] >= 0:
                if axes == LOCAL:
                    a0, a1, a2 = a0 - m0[j], a1 - m1[j], a2 - m2[j]
                if axes != SPATIAL:
                    b0, b1, b2 = b0 + s0[j], b1 + s1[j], b2 + s2[j]
        slope[i] = a0 * G[i + 3 * n] + a1 * G[i + 4 * n] + a2 * G[i + 5 * n] + b0 * G[i] + b1 * G[i + n] + b2 * G[i + 2 * n]


@inner
def manipulability(frame, n, axes, reading, rows, order, slope, work):
    r"""Yoshikawa's measure :math:`w = \sigma_1 \cdots \sigma_m`, and its gradient.

    With :math:`J = \sum_k \sigma_k u_k v_k^T` the sensitivity to J is :math:`w (J^\#)^T`, which is
    :math:`\sum_k (w / \sigma_k) u_k v_k^T`. Where J loses rank w has an edge, as the norm of a vector has at 0: on all
    sides it rises, and the gradient is 0, as that of a balanced difference.

    Parameters
    ----------
    frame : (26 + 6 * n,)
        See :mod:`tasks.kernels.block`.
    axes : int
        WORLD, LOCAL or SPATIAL.
    reading : (rows * 6,)
        See :func:`jacobian`.
    order : int (n,)
        See :func:`gradient`.
    slope : (n,)
        On return the gradient [unit of w per rad, or per m].
    work : (18 * n + rows * (n + rows + 1),)

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
def svd(frame, n, axes, reading, rows, work):
    """The singular values of what a task reads of a frame, with G at the beginning of work; see :func:`decompose`."""
    first = 18 * n
    second = first + rows * n
    third = second + rows * rows
    J, ways, sizes = work[first:second], work[second:third], work[third : third + rows]
    jacobian(frame, n, axes, reading, rows, work[: 6 * n], J)
    decompose(J, rows, n, ways, sizes)
    return J, ways, sizes


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
    work : (20 * n + rows * (n + rows + 1),)

    Returns
    -------
    r : float
    """
    G, C, own = work[: 6 * n], work[6 * n : 12 * n], work[12 * n : 18 * n]
    J, ways, sizes = svd(frame, n, axes, reading, rows, work)
    z = work[18 * n + rows * (n + rows + 1) :]
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
    work : (20 * n + rows * (n + rows + 3) + 12,)

    Returns
    -------
    r : float
    """
    first = 20 * n + rows * (n + rows + 1)
    u, pull, seen, force = (
        work[first : first + rows],
        work[first + rows : first + 2 * rows],
        work[first + 2 * rows : first + 2 * rows + 6],
        work[first + 2 * rows + 6 : first + 2 * rows + 12],
    )
    along(frame, axes, desired[0], desired[1], desired[2], desired[3], desired[4], desired[5], seen, 0, 1)
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


@inner
def joint_centring(joints, columns, low, high, count, slope):
    r"""The mean squared distance of joints from the middle of their ranges, in halves of these, and its gradient.

    Parameters
    ----------
    joints : (n,)
        Positions of the joints.
    columns : int (count,)
        Those that have a range.
    low, high, slope : (count,)

    Returns
    -------
    H : float
    """
    total = 0.0
    for k in range(count):
        half = 0.5 * (high[k] - low[k])
        away = (joints[columns[k]] - 0.5 * (high[k] + low[k])) / half
        total += away * away
        slope[k] = 2.0 * away / (count * half)
    return total / count


@inner
def climb(slope, columns, count, gain, up, v, order, lower, upper):
    """Bounds of the law of a gradient: ``x = K slope`` at velocity order, ``K^2 slope - 2 K v`` at acceleration order.

    Parameters
    ----------
    slope : (count,)
    columns : int (count,)
        Which velocities the rows are.
    up : float
        1.0 where the scalar is to rise, -1.0 where it is to fall.
    order : int
        1 at velocity order, 2 at acceleration order.
    """
    for k in range(count):
        wanted = up * gain * slope[k]
        if order == 2:
            wanted = gain * wanted - 2.0 * gain * v[columns[k]]
        lower[k] = upper[k] = wanted


@inner
def least_motion(v, n, braking, lower, upper):
    """Bounds of the least motion of each joint: 0, or at acceleration order ``-K v``; `braking` is K, or 0."""
    for j in range(n):
        lower[j] = upper[j] = -braking * v[j] if braking != 0.0 else 0.0


@inner
def kinetic_energy(M, v, n, braking, A, lower, upper):
    """Rows of the least kinetic energy, ``L^T x = -L^T K v`` for M = L L^T; `braking` is K, or 0."""
    root(M, n, A)
    for r in range(n):
        total = 0.0 * A[r * n]  # NaN where M has no root
        if braking != 0.0:
            for j in range(r, n):
                total -= A[r * n + j] * (braking * v[j])
        lower[r] = upper[r] = total


@inner
def minimum_torque(M, bias, middle, n, A, lower, upper):
    """Rows of the least torque, ``M x = middle - bias``."""
    for t in range(n * n):
        A[t] = M[t]
    for r in range(n):
        lower[r] = upper[r] = middle[r] - bias[r]
