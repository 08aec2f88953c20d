r"""Curvature of a frame's motion: its acceleration at constant joint velocities, as a quadratic form of these.

Let :math:`z_a` be the axes of the joints (zero for prismatic ones) and :math:`J_a` the columns of the Jacobian of a
point, both along the axes of the world. A joint a that carries joint b rotates the column of b, so

.. math::

    f \cdot \ddot p = \sum_{ab} v_a v_b \, (f \times z_a) \cdot J_b, \qquad
    g \cdot \dot\omega = \sum_{ab} v_a v_b \, \tfrac12 (g \times z_a) \cdot z_b ,

where in each pair a carries b, or a = b. Joints on different branches have no common terms. The axes of one joint with
several velocities, as a ball joint or a floating base, are fixed to the body that it moves: neither carries the other,
so :math:`\ddot p` has half of both terms, and :math:`\dot\omega` has none. The columns of the centre of mass obey the
same law.

The curvature of a task's value also has terms from the motion of its own axes. These are forms
:math:`w \cdot (X y \times Y y)` of the velocities y of the frame: each is a matrix K, and with the Jacobian L of y

.. math:: S = S_p(f) + S_\omega(g) + L^T K L.
"""

from __future__ import annotations

from hqp.kernels.compile import inner
from hqp.kernels.memory import floats, ints

from . import block as at

#: Table of a frame in the world: unknowns; its block; the axes of the joints, the stride from one axis to the next and
#: from one coordinate to the next; number of pairs of joints, and the pairs: carrying joint, carried joint, and whether
#: they are the same joint; in the order of the first. The same joint by joint: how many there are; which one carries
#: each directly (-1: none) and where its velocities begin and end, (joints, 3), what carries comes first; the
#: velocities; and room for sums, (joints + 1, 6).
N, BLOCK, AXES, ACROSS, DOWN, COUNT, PAIRS, JOINTS, CHAIN, VELOCITIES, SUMS = range(11)
LENGTH = 11
#: Table of a frame seen from another one, its root: the tables of both in the world (0: no root), and the block.
FRAME, ROOT, SEEN = range(3)
#: Velocities y (9,): linear and angular of the frame, as the root sees it; angular of the root, in its own axes.
LINEAR, ANGULAR, TURNING = 0, 3, 6
Y = 9
#: Work space: f, g; K by rows; two maps X, Y (3 x 9), by rows; a column of L, and K times it.
F, G, K, ONE, OTHER, COLUMN, TIMES = 0, 3, 6, 87, 114, 141, 150
WORK_SIZE = 160


@inner
def frame_curvature(table, f0, f1, f2, g0, g1, g2, S):
    """Add the quadratic form of f . p'' + g . omega' of a frame in the world to S (n * n,); `table` is its address."""
    told = ints(table, 0, LENGTH)
    n, across, down = told[N], told[ACROSS], told[DOWN]
    J = floats(told[BLOCK], at.JACOBIAN, 3 * n)
    z = floats(told[AXES], 0, (n - 1) * across + 2 * down + 1)
    pairs, last, turns = ints(told[PAIRS], 0, 3 * told[COUNT]), -1, g0 != 0.0 or g1 != 0.0 or g2 != 0.0
    x0 = x1 = x2 = y0 = y1 = y2 = 0.0
    for k in range(told[COUNT]):
        a, b, one = pairs[3 * k], pairs[3 * k + 1], pairs[3 * k + 2] != 0
        if a != last:  # f x z_a and g x z_a / 2, for all that a carries
            x, y, w, last = z[a * across], z[a * across + down], z[a * across + 2 * down], a
            x0, x1, x2 = f1 * w - f2 * y, f2 * x - f0 * w, f0 * y - f1 * x
            y0, y1, y2 = 0.5 * (g1 * w - g2 * y), 0.5 * (g2 * x - g0 * w), 0.5 * (g0 * y - g1 * x)
        bend = x0 * J[b] + x1 * J[n + b] + x2 * J[2 * n + b]
        if one or turns:
            j = b * across
            p, q, r = z[j], z[j + down], z[j + 2 * down]
            if one:
                back = (f1 * r - f2 * q) * J[a] + (f2 * p - f0 * r) * J[n + a] + (f0 * q - f1 * p) * J[2 * n + a]
                bend = 0.5 * (bend + back)
            else:
                bend += y0 * p + y1 * q + y2 * r
        S[a * n + b] += bend
        if a != b:
            S[b * n + a] += bend


@inner
def no_map(work, first):
    """Set the map (3 x 9) at work[first:] to zero."""
    for k in range(3 * Y):
        work[first + k] = 0.0


@inner
def add_part(work, first, part, scale):
    """Add to the map at work[first:]: y -> scale v, where v are the three velocities y[part:part + 3]."""
    for r in range(3):
        work[first + Y * r + part + r] += scale


@inner
def add_cross(work, first, x, y, z, part, scale):
    """Add to the map at work[first:]: y -> scale (x, y, z) x v, where v are the velocities y[part:part + 3]."""
    work[first + part + 1] -= scale * z
    work[first + part + 2] += scale * y
    work[first + Y + part] += scale * z
    work[first + Y + part + 2] -= scale * x
    work[first + 2 * Y + part] -= scale * y
    work[first + 2 * Y + part + 1] += scale * x


@inner
def add_outer(work, first, x, y, z, part):
    """Add to the map at work[first:]: y -> a (a . v), where a = (x, y, z) and v are the velocities y[part:part + 3]."""
    for r in range(3):
        own = x if r == 0 else y if r == 1 else z
        work[first + Y * r + part] += own * x
        work[first + Y * r + part + 1] += own * y
        work[first + Y * r + part + 2] += own * z


@inner
def crossed_map(work, first, x, y, z, other):
    """Write the map y -> (x, y, z) x m(y) to work[first:], where m is the map at work[other:]."""
    for c in range(Y):
        a, b, d = work[other + c], work[other + Y + c], work[other + 2 * Y + c]
        work[first + c] = y * d - z * b
        work[first + Y + c] = z * a - x * d
        work[first + 2 * Y + c] = x * b - y * a


@inner
def add_form(work, x, y, z, scale):
    """Add ``scale w . (X y x Y y)`` to K, for w = (x, y, z) and the maps X, Y in the work space."""
    for i in range(Y):
        a, b, c = work[ONE + i], work[ONE + Y + i], work[ONE + 2 * Y + i]
        a, b, c = scale * (y * c - z * b), scale * (z * a - x * c), scale * (x * b - y * a)  # w x X
        for j in range(Y):
            own = 0.5 * (a * work[OTHER + j] + b * work[OTHER + Y + j] + c * work[OTHER + 2 * Y + j])
            work[K + Y * i + j] += own
            work[K + Y * j + i] += own


@inner
def seen_curvature(table, work, S):
    """Add the form of a frame seen from its root, S_p(f) + S_omega(g) + L' K L, to S (n * n,).

    f, g and K are in the work space, along the axes of the root. The terms of a moving root are those of
    :func:`.frames.relative_frame`.
    """
    told = ints(table, 0, 3)
    f0, f1, f2, g0, g1, g2 = work[F], work[F + 1], work[F + 2], work[G], work[G + 1], work[G + 2]
    n = ints(told[FRAME], 0, LENGTH)[N]
    block = floats(told[SEEN], 0, at.JACOBIAN)
    root = told[ROOT]
    if root == 0:
        frame_curvature(told[FRAME], f0, f1, f2, g0, g1, g2, S)
    else:
        R = floats(ints(root, 0, LENGTH)[BLOCK], at.ROTATION, 9)
        no_map(work, ONE)
        no_map(work, OTHER)
        add_part(work, ONE, TURNING, 1.0)
        add_part(work, OTHER, LINEAR, -2.0)
        add_cross(work, OTHER, block[0], block[1], block[2], TURNING, 1.0)  # - omega_0 x r
        add_form(work, f0, f1, f2, 1.0)
        no_map(work, OTHER)
        add_part(work, OTHER, ANGULAR, -1.0)
        add_form(work, g0, g1, g2, 1.0)
        # - f . (omega_0' x r) is omega_0' . (f x r)
        h0 = f1 * block[2] - f2 * block[1] - g0
        h1 = f2 * block[0] - f0 * block[2] - g1
        h2 = f0 * block[1] - f1 * block[0] - g2
        f0, f1, f2 = turned(R, f0, f1, f2)
        g0, g1, g2 = turned(R, g0, g1, g2)
        h0, h1, h2 = turned(R, h0, h1, h2)
        frame_curvature(told[FRAME], f0, f1, f2, g0, g1, g2, S)
        frame_curvature(root, -f0, -f1, -f2, h0, h1, h2, S)
    add_velocities(told, root, n, work, S)


@inner
def turned(R, x, y, z):
    """``R (x, y, z)``."""
    return (
        R[0] * x + R[1] * y + R[2] * z,
        R[3] * x + R[4] * y + R[5] * z,
        R[6] * x + R[7] * y + R[8] * z,
    )


@inner
def column(told, root, n, j, out, begin):
    """Write column j of L, the Jacobian of the velocities y, to out[begin:begin + 9]."""
    J = floats(told[SEEN], at.JACOBIAN, 6 * n)
    for k in range(6):
        out[begin + k] = J[k * n + j]
    out[begin + 6] = out[begin + 7] = out[begin + 8] = 0.0
    if root != 0:
        place = ints(root, 0, LENGTH)[BLOCK]
        R, Z = floats(place, at.ROTATION, 9), floats(place, at.JACOBIAN + 3 * n, 3 * n)
        for k in range(3):
            out[begin + 6 + k] = R[k] * Z[j] + R[3 + k] * Z[n + j] + R[6 + k] * Z[2 * n + j]


@inner
def add_velocities(told, root, n, work, S):
    """Add L' K L to S, column by column; columns of joints that move neither frame nor root are zero.

    K is symmetric; most often it is zero but for the rows `first` .. `end` - 1.
    """
    first, end = Y, 0
    for r in range(Y):
        for c in range(r, Y):
            if work[K + Y * r + c] != 0.0:
                first, end = min(first, r), max(end, c + 1)
    J = floats(told[SEEN], at.JACOBIAN, 6 * n)
    for j in range(n if end > 0 else 0):
        if root != 0:
            column(told, root, n, j, work, COLUMN)
        else:  # nothing turns below it
            for r in range(first, end):
                work[COLUMN + r] = J[r * n + j]
        moves = False
        for r in range(first, end):
            total = 0.0
            for c in range(first, end):
                total += work[K + Y * r + c] * work[COLUMN + c]
            work[TIMES + r] = total
            moves = moves or total != 0.0
        for i in range(j + 1 if moves else 0):
            total = 0.0
            if root == 0:
                for r in range(first, end):
                    total += work[TIMES + r] * J[r * n + i]
            else:
                column(told, root, n, i, work, COLUMN)
                for r in range(first, end):
                    total += work[TIMES + r] * work[COLUMN + r]
            S[i * n + j] += total
            if i != j:
                S[j * n + i] += total
