r"""The loop that finds the contact forces that bear a robot at rest.

Of all forces f that meet the rows of the base at :math:`a = 0`, :math:`G_u^T f = b_u`, those with the least
:math:`\sum f_i^2 / w_i` are

.. math:: f = W G_u\, y, \qquad (G_u^T W G_u)\, y = b_u .
"""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

from ...base.kernels.algebra import fill, root, solve_lower, solve_upper
from . import layout as own

#: Table: number n of joint velocities, of rows of the base, of forces; the bias b (n,), G (forces, n); w (forces,) of
#: contacts that are on; number of contacts, their list; number of places for f, their list; a work space.
N, ROWS, FORCES, BIAS, WRENCHES, EASE, CONTACTS, TABLE, PLACES, OUT, WORK = range(11)
#: Entries of a contact: its slot; its first force, and how many it has.
SLOT, FIRST, SIZE = range(3)
FIELDS = 3
#: Share of the trace that is added to the diagonal: where the contacts cannot bear the robot, f is least squares.
SMALL = 1e-12


@stamp
@entry
def write_bearing_forces(here):
    """Write the least forces that bear the robot at rest; contacts bear by the share of their ramp, loops nothing."""
    told = ints(here, 0, WORK + 1)
    n, rows, count = told[N], told[ROWS], told[FORCES]
    b, ease = floats(told[BIAS], 0, rows), floats(told[EASE], 0, count)
    f, y = floats(told[WORK], 0, count), floats(told[WORK], count, rows)
    A, R = floats(told[WORK], count + rows, rows * rows), floats(told[WORK], count + rows * (rows + 1), rows * rows)
    fill(f, count, 0.0)
    fill(A, rows * rows, 0.0)
    for c in range(told[CONTACTS]):  # f is w, until y is known
        contact = ints(told[TABLE], FIELDS * c, FIELDS)
        share = floats(contact[SLOT], 0, own.SLOT_SIZE)[own.SHARE]
        for i in range(contact[FIRST], contact[FIRST] + contact[SIZE]):
            f[i] = share * ease[i]
            G = floats(told[WRENCHES], i * n, rows)
            for r in range(rows):
                for k in range(rows):
                    A[r * rows + k] += f[i] * G[r] * G[k]
    trace = 0.0
    for r in range(rows):
        trace += A[r * rows + r]
        y[r] = b[r]
    if trace > 0.0:  # some contact bears
        for r in range(rows):
            A[r * rows + r] += SMALL * trace
        root(A, rows, R)
        solve_lower(R, rows, y)
        solve_upper(R, rows, y)
    for i in range(count):
        G = floats(told[WRENCHES], i * n, rows)
        total = 0.0
        for r in range(rows):
            total += G[r] * y[r]
        f[i] *= total
    for p in range(told[PLACES]):
        out = floats(ints(told[OUT], p, 1)[0], 0, count)
        for i in range(count):
            out[i] = f[i]
    return 0
