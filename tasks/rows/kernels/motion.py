r"""The motion equation as rows of all unknowns x = (a, f): :math:`M a + b - G^T f`, for a range of joint velocities."""

from __future__ import annotations

from hqp.kernels.compile import inner
from hqp.kernels.memory import floats, ints

#: Table: number n of joint velocities, of all unknowns; the first velocity that has a row, and how many have one; the
#: mass matrix M (n, n), the bias b (n,), G (unknowns - n, n); and the rows that are written (rows, unknowns).
N, UNKNOWNS, FIRST, ROWS, MASSES, BIAS, WRENCHES, MATRIX = range(8)
LENGTH = 8


@inner
def motion_rows(here):
    """Write the rows (M, -G^T); `here` is the address of a table that begins with the entries above."""
    told = ints(here, 0, LENGTH)
    n, width, first, rows = told[N], told[UNKNOWNS], told[FIRST], told[ROWS]
    A, M = floats(told[MATRIX], 0, rows * width), floats(told[MASSES], first * n, rows * n)
    for r in range(rows):
        for j in range(n):
            A[r * width + j] = M[r * n + j]
    G = floats(told[WRENCHES], 0, (width - n) * n)
    for i in range(width - n):
        for r in range(rows):
            A[r * width + n + i] = -G[i * n + first + r]
