"""Copies rows of the joint motion into rows of all unknowns."""

from __future__ import annotations

from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import floats, ints

#: Table: number of matrices, of joint velocities nv, of all unknowns n; the list of matrices. Of each: the matrix
#: (rows, nv), where it is copied to (rows, n), and its number of rows.
COUNT, JOINTS, UNKNOWNS, MATRICES = range(4)
FROM, TO, ROWS = range(3)
FIELDS = 3


@stamp
@entry
def embed_joints(here):
    """Copy each matrix (rows, nv) into the first nv columns of a matrix (rows, n)."""
    told = ints(here, 0, 4)
    nv, n = told[JOINTS], told[UNKNOWNS]
    for k in range(told[COUNT]):
        matrix = ints(told[MATRICES], FIELDS * k, FIELDS)
        rows = matrix[ROWS]
        own, whole = floats(matrix[FROM], 0, rows * nv), floats(matrix[TO], 0, rows * n)
        for r in range(rows):
            for j in range(nv):
                whole[r * n + j] = own[r * nv + j]
    return 0
