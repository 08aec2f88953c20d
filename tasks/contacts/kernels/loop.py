"""Writes the rows that close a kinematic loop, and the map from its forces to joint torques."""

from __future__ import annotations

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.rotation import crossed, rotation_vector
from ...robots.kernels import block as at
from ...rows.kernels import law as of

#: Table: the table of the law; blocks of both frames, and a point on each; whether the relative rotation of the frames
#: was stored, and that rotation (1 + 9, by rows); work space; G, and its number of rows.
LAW, FIRST, SECOND, POINT, OTHER, KEPT, WORK, MAP, FORCES = range(9)
#: Up to this share of the longest entry an entry is round-off: the difference of two columns that are the same.
ROUND_OFF = 1e-12


@inner
def moved(block, J, point, n, sign, rows, A, measured, r):
    """Add `sign` times the Jacobian of a point of a frame to A, and its drift, and minus its position, to `measured`.

    With more than 3 rows, the rotation of the frame counts as well. r (3,) is work space.
    """
    for k in range(3):
        row = at.ROTATION + 3 * k
        r[k] = block[row] * point[0] + block[row + 1] * point[1] + block[row + 2] * point[2]
    for j in range(n):
        a, b, c = J[3 * n + j], J[4 * n + j], J[5 * n + j]
        A[j] += sign * (J[j] + b * r[2] - c * r[1])
        A[n + j] += sign * (J[n + j] + c * r[0] - a * r[2])
        A[2 * n + j] += sign * (J[2 * n + j] + a * r[1] - b * r[0])
        if rows > 3:
            A[3 * n + j] += sign * a
            A[4 * n + j] += sign * b
            A[5 * n + j] += sign * c
    w, d = block[at.ANGULAR_VELOCITY : at.ANGULAR_VELOCITY + 3], of.DRIFT * rows
    for k in range(rows):
        measured[d + k] += sign * block[at.LINEAR_DRIFT + k]
    al = block[at.ANGULAR_DRIFT : at.ANGULAR_DRIFT + 3]
    crossed(al[0], al[1], al[2], r[0], r[1], r[2], sign, measured, d)
    x, y, z = w[1] * r[2] - w[2] * r[1], w[2] * r[0] - w[0] * r[2], w[0] * r[1] - w[1] * r[0]
    crossed(w[0], w[1], w[2], x, y, z, sign, measured, d)
    for k in range(3):
        measured[k] -= sign * (block[k] + r[k])


@inner
def cleared(J, other, n, rows, A):
    """Clear columns of joints that carry both frames, which cannot open the loop, and entries that are round-off.

    Both points count as one, whatever gap there is: across a gap, as springs of physics leave it, forces on both would
    turn the whole robot. A row of round-off would count as a row, and take a direction from the levels below: that of a
    pin across the plane of a planar chain does so.
    """
    longest = 0.0
    for j in range(n):
        turns = abs(J[3 * n + j]) + abs(J[4 * n + j]) + abs(J[5 * n + j])
        carries = turns * (abs(other[3 * n + j]) + abs(other[4 * n + j]) + abs(other[5 * n + j])) > 0.0
        for k in range(rows):
            if carries:
                A[k * n + j] = 0.0
            longest = max(longest, abs(A[k * n + j]))
    for k in range(rows * n):
        if abs(A[k]) <= ROUND_OFF * longest:
            A[k] = 0.0


@inner
def turned(first, second, kept, measured, work):
    """Write the error of the relative rotation, log(R_b C R_a^T), to measured[3:6]; C = R_b^T R_a at the first call.

    `kept` (10,) stores C; a and b are the blocks `first` and `second`.
    """
    a, b = first[at.ROTATION : at.ROTATION + 9], second[at.ROTATION : at.ROTATION + 9]
    known = a[0] + b[0]
    if kept[0] == 0.0 and known == known:
        for r in range(3):
            for c in range(3):
                kept[1 + 3 * r + c] = b[r] * a[c] + b[3 + r] * a[3 + c] + b[6 + r] * a[6 + c]
        kept[0] = 1.0
    for r in range(3):
        for c in range(3):
            total = 0.0
            for k in range(3):
                for m in range(3):
                    total += b[3 * r + k] * kept[1 + 3 * k + m] * a[3 * c + m]
            work[3 * r + c] = total
    rotation_vector(work, measured, 3)


@stamp
@entry
def write_loop(here):
    """Write the rows that keep both points together and, with six rows, the relative rotation of the frames."""
    told = ints(here, 0, FORCES + 1)
    law = ints(told[LAW], 0, of.LENGTH)
    rows, n = law[of.ROWS], law[of.N]
    A, measured = floats(law[of.MATRIX], 0, rows * n), floats(law[of.MEASURED], 0, of.KINDS * rows)
    work = floats(told[WORK], 0, 64)
    for k in range(rows * n):
        A[k] = 0.0
    for k in range(of.KINDS * rows):
        measured[k] = 0.0
    first, second = floats(told[FIRST], 0, at.JACOBIAN), floats(told[SECOND], 0, at.JACOBIAN)
    J, point = floats(told[FIRST], at.JACOBIAN, 6 * n), floats(told[POINT], 0, 3)
    moved(first, J, point, n, 1.0, rows, A, measured, work)
    J, point = floats(told[SECOND], at.JACOBIAN, 6 * n), floats(told[OTHER], 0, 3)
    moved(second, J, point, n, -1.0, rows, A, measured, work)
    if rows > 3:
        turned(first, second, floats(told[KEPT], 0, 10), measured, work)
    if law[of.DRIFTS] == 0:
        for k in range(rows):
            measured[of.DRIFT * rows + k] = 0.0
    cleared(floats(told[FIRST], at.JACOBIAN, 6 * n), J, n, rows, A)
    G = floats(told[MAP], 0, told[FORCES] * n)
    for k in range(told[FORCES] * n):
        G[k] = A[k]  # forces do no work on motions that keep the loop closed, nor do they push the whole robot
    of.moving(told[LAW])
    of.law(told[LAW])
    return 0
