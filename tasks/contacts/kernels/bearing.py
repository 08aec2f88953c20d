r"""The loop that finds the contact forces that bear a robot at rest.

Of all forces f at points whose normal parts push, and that meet the rows of the base at :math:`a = 0`,
:math:`G_u^T f = b_u`, those with the least :math:`\sum f_i^2 / w_i` are

.. math:: f = W \max(G_u\, y, 0), \qquad G_u^T f = b_u,

where the maximum is for normal forces alone. Newton's method finds y: each step leaves out those that
would pull at the last y. Then forces are cut off, see :func:`cut_off`.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import fill, largest, root, solve_lower, solve_upper
from . import layout as own

#: Table: number n of joint velocities, of rows of the base, of forces; the bias b (n,), G (forces, n); number of
#: points, their list, where the points of a wrench are along t1 and t2 (points, 2) [m]; number of places for f, their
#: list; a work space.
N, ROWS, FORCES, BIAS, WRENCHES, POINTS, TABLE, ARMS, PLACES, OUT, WORK = range(11)
#: Entries of a point: the slot of its contact; the first force; whether forces are one wrench; whether it can pull.
SLOT, FIRST, WRENCH, PULLS = range(4)
FIELDS = 4
#: Share of the trace that is added to the diagonal, as contacts may not bear the robot in all directions.
SMALL = 1e-9
#: Most steps, about 3 where the contacts can bear the robot; and which share of b may be left.
STEPS, LEFT = 12, 1e-10


@inner
def map_of_point(told, i, H):
    """Write the rows of G of the three forces at point i to H (3 * rows,)."""
    n, rows, point, arm = told[N], told[ROWS], ints(told[TABLE], FIELDS * i, FIELDS), floats(told[ARMS], 2 * i, 2)
    first, x, y = point[FIRST], arm[0], arm[1]
    for k in range(3):
        G = floats(told[WRENCHES], (first + k) * n, rows)
        for r in range(rows):
            H[k * rows + r] = G[r]
    if point[WRENCH] != 0:  # a force at (x, y) has a moment about the centre, too
        about1, about2 = floats(told[WRENCHES], (first + 3) * n, rows), floats(told[WRENCHES], (first + 4) * n, rows)
        about3 = floats(told[WRENCHES], (first + 5) * n, rows)
        for r in range(rows):
            H[r] -= y * about3[r]
            H[rows + r] += x * about3[r]
            H[2 * rows + r] += y * about1[r] - x * about2[r]


@inner
def forces_of_point(told, i, H, y, f):
    """Write the forces at point i to f (3,); returns its share."""
    rows, point = told[ROWS], ints(told[TABLE], FIELDS * i, FIELDS)
    share = floats(point[SLOT], 0, own.SLOT_SIZE)[own.SHARE]
    for k in range(3):
        total = 0.0
        for r in range(rows):
            total += H[k * rows + r] * y[r]
        f[k] = share * total
    if f[2] < 0.0 and point[PULLS] == 0:
        f[2] = 0.0
    return share


@inner
def newton_step(told, step, maps, y, left, A, R):
    """Take one step of y; returns False where there is nothing left to do."""
    rows, count = told[ROWS], told[POINTS]
    b, f = floats(told[BIAS], 0, rows), R
    fill(A, rows * rows, 0.0)
    for r in range(rows):
        left[r] = b[r]
    for i in range(count):
        H = maps[3 * rows * i : 3 * rows * (i + 1)]
        share = forces_of_point(told, i, H, y, f)
        for k in range(3 if step == 0 or f[2] != 0.0 else 2):
            for r in range(rows):
                left[r] -= H[k * rows + r] * f[k]
                for c in range(rows):
                    A[r * rows + c] += share * H[k * rows + r] * H[k * rows + c]
    trace = 0.0
    for r in range(rows):
        trace += A[r * rows + r]
    if not trace > 0.0 or largest(left, rows) <= LEFT * largest(b, rows):
        return False
    for r in range(rows):
        A[r * rows + r] += SMALL * trace
    root(A, rows, R)
    solve_lower(R, rows, left)
    solve_upper(R, rows, left)
    for r in range(rows):
        y[r] += left[r]
    return True


@inner
def cut_off(f, most):
    """Cut forces f (3,) at a point that pushes off: the normal one at `most`, the others at the normal one.

    Where forces inside no cone bear the robot, feet at nearly the same height would do it by any tangential forces.
    """
    f[2] = min(f[2], most)
    along = math.sqrt(f[0] * f[0] + f[1] * f[1])
    if along > f[2]:
        f[0], f[1] = f[0] * f[2] / along, f[1] * f[2] / along


@stamp
@entry
def write_bearing_forces(here):
    """Write the least forces that bear the robot at rest; contacts bear by the share of their ramp, loops nothing."""
    told = ints(here, 0, WORK + 1)
    rows, forces, count = told[ROWS], told[FORCES], told[POINTS]
    y, left, A = floats(told[WORK], 0, rows), floats(told[WORK], rows, rows), floats(told[WORK], 2 * rows, rows * rows)
    R, maps = (
        floats(told[WORK], rows * (2 + rows), rows * rows),
        floats(told[WORK], 2 * rows * (1 + rows), 3 * rows * count),
    )
    f, all_of = R, floats(told[WORK], 2 * rows * (1 + rows) + 3 * rows * count, forces)
    b = floats(told[BIAS], 0, rows)
    most = math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])  # all that is to be borne
    fill(y, rows, 0.0)
    fill(all_of, forces, 0.0)
    for i in range(count):
        map_of_point(told, i, maps[3 * rows * i : 3 * rows * (i + 1)])
    for step in range(STEPS):
        if not newton_step(told, step, maps, y, left, A, R):
            break
    for i in range(count):
        point, arm = ints(told[TABLE], FIELDS * i, FIELDS), floats(told[ARMS], 2 * i, 2)
        forces_of_point(told, i, maps[3 * rows * i : 3 * rows * (i + 1)], y, f)
        if point[PULLS] == 0:
            cut_off(f, most)
        own_forces = all_of[point[FIRST] :]
        for k in range(3):
            own_forces[k] += f[k]
        if point[WRENCH] != 0:
            own_forces[3] += arm[1] * f[2]
            own_forces[4] -= arm[0] * f[2]
            own_forces[5] += arm[0] * f[1] - arm[1] * f[0]
    for p in range(told[PLACES]):
        out = floats(ints(told[OUT], p, 1)[0], 0, forces)
        for i in range(forces):
            out[i] = all_of[i]
    return 0
