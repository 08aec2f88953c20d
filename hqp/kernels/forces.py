r"""The gradient of a level, as the certificate has it: the sum of its forces, rows times their slacks.

.. math:: g = \frac{1}{s} \sum_i w_i a_i, \qquad s = \sum_i \|a_i\|\, |w_i|,

of the implicit last level :math:`x - x_\text{ref}`. At first, slacks within the tolerances of their rows count as zero:
of rows that are met they are but round-off. But where rows nearly depend on each other, or are short, those that
balance the others may be as small; so a level that is not balanced is judged once more with all slacks as they are.
What may be left of its forces is a share of the same s.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import ints, marks, matrix, vector
from .shift import STATIONARITY
from .states import ROUND_OFF


@inner
def gradient(here, k, way):
    """Write the gradient ``g`` of level k, divided by the sum of its forces; returns that sum, 0 if the level is met.

    The tolerances of x_j on the implicit last level go to ``rhs``. `way` is that of :func:`.states.find_sides`.
    """
    head, ptr = ints(here, 0, at.HEAD), marks(here, at.PTR)
    norm, slack = vector(here, at.NORM), vector(here, at.SLOPE)
    x, x_ref, near, away = vector(here, at.X), vector(here, at.X_REF), vector(here, at.RHS), vector(here, at.SCRATCH)
    judged, scale = vector(here, at.OPTION)[at.JUDGED], 0.0
    if k == head[at.LEVELS]:
        for j in range(head[at.N]):
            near[j] = judged * (abs(x[j]) + abs(x_ref[j])) + ROUND_OFF * way
            away[j] = x[j] - x_ref[j] if abs(x[j] - x_ref[j]) > near[j] else 0.0
            scale += abs(away[j])
        write_shares(here, away, scale)
        return scale
    for i in range(ptr[k], ptr[k + 1]):
        scale += norm[i] * abs(slack[i])
    write_forces(here, k, slack, scale)
    return scale


@inner
def as_they_are(here, k, scale):
    """Write the gradient ``g`` of level k anew, with all slacks as they are; whether this may make a difference.

    `scale` is the sum that :func:`gradient` has returned.
    """
    head, ptr, norm = ints(here, 0, at.HEAD), marks(here, at.PTR), vector(here, at.NORM)
    x, x_ref, away, slack = vector(here, at.X), vector(here, at.X_REF), vector(here, at.SCRATCH), vector(here, at.W)
    total = 0.0
    if k == head[at.LEVELS]:
        for j in range(head[at.N]):
            away[j] = x[j] - x_ref[j]
            total += abs(away[j])
        write_shares(here, away, scale)
    else:
        for i in range(ptr[k], ptr[k + 1]):
            total += norm[i] * abs(slack[i])
        write_forces(here, k, slack, scale)
    return total > (1.0 + STATIONARITY) * scale


@inner
def write_shares(here, away, scale):
    """Write to ``g`` the gradient of the implicit last level, `away` (n,), as a share of `scale`, unless that is 0."""
    g = vector(here, at.G)
    for j in range(ints(here, 0, at.HEAD)[at.N]):
        g[j] = away[j] / scale if scale != 0.0 else 0.0


@inner
def write_forces(here, k, slack, scale):
    """Write to ``g`` the sum of the forces of level k, rows times their `slack` (m,), as a share of `scale`."""
    n, ptr, col, row_of = (
        ints(here, 0, at.HEAD)[at.N],
        marks(here, at.PTR),
        marks(here, at.COL),
        marks(here, at.ROW_OF),
    )
    g, norm, B = vector(here, at.G), vector(here, at.NORM), matrix(here, at.B)
    for j in range(n):
        g[j] = 0.0
    for i in range(ptr[k], ptr[k + 1]):
        if slack[i] == 0.0 or norm[i] == 0.0:
            continue
        much = slack[i] / scale
        if col[i] >= 0:
            g[col[i]] += much * norm[i]
        else:
            row = B[row_of[i]]
            for j in range(n):
                g[j] += much * row[j]
