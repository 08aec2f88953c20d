"""The loop that writes the rows of torque limits; joint motion limits are in :mod:`tasks.rows.kernels.envelope`."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

#: Of torques: the joints; the rows and their bounds; the mass matrix, the bias and the largest torques.
N, MATRIX, LOWER, UPPER, MASSES, BIAS, LARGEST = range(7)


@stamp
@entry
def write_torque_limit(here):
    r"""``-tau_max - b <= M a <= tau_max - b``."""
    told = ints(here, 0, 7)
    n = told[N]
    A, M = floats(told[MATRIX], 0, n * n), floats(told[MASSES], 0, n * n)
    lower, upper = floats(told[LOWER], 0, n), floats(told[UPPER], 0, n)
    bias, limit = floats(told[BIAS], 0, n), floats(told[LARGEST], 0, n)
    for k in range(n * n):
        A[k] = M[k]
    for j in range(n):
        lower[j], upper[j] = -limit[j] - bias[j], limit[j] - bias[j]
    return 0
