r"""The derivative of a frame's Jacobian by the joints, and the gradient of any scalar function of the Jacobian.

Let :math:`l_j, \omega_j` be the linear and angular columns of joint j along the axes of the world, and
:math:`i \preceq j` if joint i comes before j in the chain, or i = j. Then i carries j, and rotates its column;
otherwise it moves the frame relative to the axis of j:

.. math::

    \frac{\partial l_j}{\partial q_i} = \begin{cases} \omega_i \times l_j & i \preceq j \\
        \omega_j \times l_i & \text{else,} \end{cases} \qquad
    \frac{\partial \omega_j}{\partial q_i} = \begin{cases} \omega_i \times \omega_j & i \preceq j \\
        0 & \text{else.} \end{cases}

The gradient of a scalar H of J is the sum of these, weighted by the sensitivities
:math:`C^l_j = \partial H / \partial l_j`, :math:`C^\omega_j = \partial H / \partial \omega_j`. With
:math:`m_j = l_j \times C^l_j + \omega_j \times C^\omega_j` and :math:`s_j = C^l_j \times \omega_j`

.. math::

    \frac{\partial H}{\partial q_i} = \omega_i \cdot \sum_{i \preceq j} m_j
        + l_i \cdot \sum_{i \not\preceq j} s_j .

Along the axes of the frame itself, which turn with it, :math:`\omega_i \cdot \sum_j m_j` is subtracted, with all
columns in these axes. If l is the velocity of the point at the origin of the world (spatial rows),
:math:`l_i \cdot \sum_j s_j` is subtracted.
"""

from __future__ import annotations

from hqp.kernels.compile import inner

from ...base.kernels.algebra import fill
from ...frames.kernels.placement import LOCAL, SPATIAL, along
from ...robots.kernels.block import JACOBIAN


@inner
def jacobian(frame, n, axes, reading, rows, G, J, work):
    """Write the Jacobian of a frame along the axes of a task, G (6 * n,), and of the task, J = reading G (rows * n,).

    Parameters
    ----------
    frame : (26 + 6 * n,)
        The block of the frame.
    axes : int
        WORLD, LOCAL or SPATIAL.
    reading : (rows * 6,)
        Coefficients of each row for the linear and angular velocity along these axes; for a mask, a single 1.0 per row.
    work : (12,)
    """
    for j in range(n):
        for k in range(6):
            work[k] = frame[JACOBIAN + k * n + j]
        along(axes, frame, work, 0, work, 6)
        for k in range(6):
            G[k * n + j] = work[6 + k]
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
    """Write the gradient of a scalar, slope (n,), from its sensitivities C to the columns G, as the module says.

    Parameters
    ----------
    G, C : (6 * n,)
        Along the axes of the task.
    order : int (n,)
        The place of each joint in the chain that carries the frame, the same for joints that move as one; -1 if a joint
        does not move the frame.
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
        m0[j], m1[j], m2[j] = (
            y * w - z * v + b * f - c * e,
            z * u - x * w + c * d - a * f,
            x * v - y * u + a * e - b * d,
        )
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
        slope[i] = (
            a0 * G[i + 3 * n] + a1 * G[i + 4 * n] + a2 * G[i + 5 * n] + b0 * G[i] + b1 * G[i + n] + b2 * G[i + 2 * n]
        )
