r"""The sweep's last level where its rows ask for single variables, as a posture does: it needs no basis of its own.

Such rows are :math:`d_j (x_j - b_j)`, one for each of the *asked* variables, with weights of their own. With the levels
above spanned by V, and :math:`s_j = 1 / d_j`, the level is a weighted least-norm problem, whose equations have as many
unknowns as V has rows:

.. math:: \min_z \tfrac12 \sum_j d_j^2 (z_j - o_j)^2 \quad \text{subject to} \quad V z = y, \qquad
   z_j = o_j + s_j^2\, (V^T \lambda)_j .

:math:`\lambda` are the multipliers along V. For a variable j that is not asked, :math:`(V^T \lambda)_j = 0`, and
:math:`z_j` is an unknown itself:

.. math:: \begin{bmatrix} V S^2 V^T & V_U \\ V_U^T & 0 \end{bmatrix} \begin{bmatrix} \lambda \\ z_U \end{bmatrix} =
   \begin{bmatrix} y - V o \\ 0 \end{bmatrix}

Giving these variables any :math:`s_j > 0` changes no solution, and makes the first block definite. One step of
iterative refinement makes up for its condition number, which is the square of that of S.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner, integer
from .definite import cholesky
from .memory import ints, marks, matrix, vector
from .orthogonal import only_entry, padded
from .rows import entry_of
from .verdict import DECIDED

#: The largest ratio of two weights of the level.
UNEVEN = 1e3
#: The largest residual before the refinement, relative to the sizes of its terms.
ROUGH = 1e-8
#: A variable counts as told by rows if other variables leave more than this share of its squared column in them.
TOLD = 1e-4
#: A basis of the level must be so many times more work: it is needed all the same where signs of multipliers are left.
SAVES = 1.5


@inner
def variable_of(i, here):
    """The variable that row i asks for; -1 if it has other entries, or a negative one."""
    col, row_of = marks(here, at.COL), marks(here, at.ROW_OF)
    if col[i] >= 0:
        return col[i]
    row = matrix(here, at.B)[row_of[i]]
    j = only_entry(row, ints(here, 0, at.HEAD)[at.N])
    return j if j >= 0 and row[j] > 0.0 else integer(-1)


@inner
def closes(here, last):
    """Whether level `last` - 1 is equalities on single variables alone, each asked once: writes ``asks`` and ``scale``.

    The weights must be of comparable size, see UNEVEN.
    """
    head, ptr = ints(here, 0, at.HEAD), marks(here, at.PTR)
    if last < 2 or head[at.BASIS] != 0:
        return False
    n, first, end = head[at.N], ptr[last - 1], ptr[last]
    if first == end or variable_of(first, here) < 0:
        return False
    asks, scale = marks(here, at.ASKS), vector(here, at.SCALE)
    lower, upper, norm = vector(here, at.LOWER), vector(here, at.UPPER), vector(here, at.NORM)
    for j in range(n):
        asks[j] = -1
    least = most = norm[first]
    for i in range(first, end):
        j = variable_of(i, here)
        if j < 0 or asks[j] >= 0 or lower[i] != upper[i] or norm[i] == 0.0:
            return False
        asks[j] = i
        least, most = min(least, norm[i]), max(most, norm[i])
    for j in range(n):
        scale[j] = most / norm[asks[j]] if asks[j] >= 0 else 1.0
    return most <= UNEVEN * least


@inner
def pays(c, f, asked):
    """Whether V[:c] in f variables is so short that equations in its rows are less work than a basis of the level."""
    rank, own = f - c, c * (c * (f + c / 3) + 8 * f)
    return rank == 0 or 2 * f * asked * c + 4 * f * rank * (asked - rank / 2) > SAVES * own


@inner
def close(here, c, f):
    """Solve that level on top of V[:c], along which x moves by y[:c]: writes x, w, and the ``multiplier`` along V.

    False, with x as it was, if the equations are badly conditioned, or more work than they save.
    """
    asks, free, norm = marks(here, at.ASKS), marks(here, at.FREE), vector(here, at.NORM)
    lo, x, scale, start = vector(here, at.LO), vector(here, at.X), vector(here, at.D), vector(here, at.SCRATCH)
    others, asked, longest = marks(here, at.QUEUE), integer(0), 0.0
    for t in range(f):
        i = asks[free[t]]
        if i >= 0:
            asked += 1
            scale[t], start[t] = 1.0 / norm[i], lo[i] / norm[i] - x[free[t]]
            longest = max(longest, norm[i])
    if f - asked > c or not pays(c, f, asked):
        return False
    if c == f:
        spread(here, f)
        finish(here, f)
        return True
    u = integer(0)
    for t in range(f):
        if asks[free[t]] < 0:
            others[u], scale[t], start[t] = t, 1.0 / longest, 0.0
            u += 1
    if not (decompose(here, c, u, f) and balance(here, c, u, f)):
        return False
    finish(here, f)
    return True


@inner
def spread(here, f):
    """The same where the levels above leave nothing: V is square."""
    scale, start, free, asks = vector(here, at.D), vector(here, at.SCRATCH), marks(here, at.FREE), marks(here, at.ASKS)
    y, z, multiplier, V = vector(here, at.Y), vector(here, at.G), vector(here, at.MULTIPLIER), matrix(here, at.V)
    along = vector(here, at.BALANCE)
    for t in range(f):
        z[t] = 0.0
    for q in range(f):
        row, step = V[q], y[q]
        for t in range(f):
            z[t] += step * row[t]
    for t in range(f):
        along[t] = (z[t] - start[t]) / (scale[t] * scale[t]) if asks[free[t]] >= 0 else 0.0
    for q in range(f):
        row, total = V[q], 0.0
        for t in range(f):
            total += row[t] * along[t]
        multiplier[q] = total


@inner
def decompose(here, c, u, f):
    """Factor V S^2 V', in H, and its Schur complement for the u variables that are not asked; False if one is singular.

    Row j of R has column j of V_U, divided by the first factor.
    """
    scale, others, wide = vector(here, at.D), marks(here, at.QUEUE), padded(f)
    V, R, H, F = matrix(here, at.V), matrix(here, at.R), matrix(here, at.H), matrix(here, at.FACTOR)
    for q in range(c):
        row, scaled, own = V[q], R[q], H[q]
        for t in range(f):
            scaled[t] = row[t] * scale[t]
        for t in range(f, wide):
            scaled[t] = 0.0
        for p in range(q + 1):
            other, total = R[p], 0.0
            for t in range(wide):
                total += scaled[t] * other[t]
            own[p] = total
    if not cholesky(H, H, c):
        return False
    for j in range(u):
        column, t = R[j], others[j]
        for q in range(c):
            row, total = H[q], V[q][t]
            for p in range(q):
                total -= row[p] * column[p]
            column[q] = total / row[q]
        own = F[j]
        for i in range(j + 1):
            other, total = R[i], 0.0
            for q in range(c):
                total += column[q] * other[q]
            own[i] = total
    return cholesky(F, F, u)


@inner
def balance(here, c, u, f):
    """Solve the equations for the ``multiplier`` along V, z, ``g``, and V' lambda, ``balance``; False if too rough.

    The residuals are refined once; then z is moved to the nearest point at which those of the levels above are zero.
    """
    scale, start, others = vector(here, at.D), vector(here, at.SCRATCH), marks(here, at.QUEUE)
    y, z, multiplier, left = vector(here, at.Y), vector(here, at.G), vector(here, at.MULTIPLIER), vector(here, at.RHS)
    along, unknown, V = vector(here, at.BALANCE), vector(here, at.SHARE), matrix(here, at.V)
    for q in range(c):
        multiplier[q] = 0.0
    for j in range(u):
        unknown[j] = 0.0
    for turn in range(3):
        size = 0.0
        for t in range(f):
            along[t] = 0.0
        for q in range(c if turn > 0 else 0):
            row, much = V[q], multiplier[q]
            for t in range(f):
                along[t] += much * row[t]
        for t in range(f):
            z[t] = start[t] + scale[t] * scale[t] * along[t]
        for j in range(u):
            z[others[j]] = unknown[j]
        for t in range(f):
            size = max(size, abs(z[t]), abs(start[t]))
        away = 0.0
        for q in range(c):
            row, total = V[q], y[q]
            for t in range(f):
                total -= row[t] * z[t]
            left[q], away, size = total, max(away, abs(total)), max(size, abs(y[q]))
        if turn == 1 and away > ROUGH * size:
            return False
        if turn < 2:
            correct(here, c, u)
    for q in range(c):  # large weights have magnified round-off, which only the levels above would feel
        row, much = V[q], left[q]
        for t in range(f):
            z[t] += much * row[t]
    return True


@inner
def correct(here, c, u):
    """Add to ``multiplier`` and to the unknowns, ``share``, what the residuals ``rhs`` and ``balance`` ask for."""
    others, left, along = marks(here, at.QUEUE), vector(here, at.RHS), vector(here, at.BALANCE)
    multiplier, unknown, more = vector(here, at.MULTIPLIER), vector(here, at.SHARE), vector(here, at.LENGTHS)
    R, H, F = matrix(here, at.R), matrix(here, at.H), matrix(here, at.FACTOR)
    for q in range(c):
        row, total = H[q], left[q]
        for p in range(q):
            total -= row[p] * left[p]
        left[q] = total / row[q]
    for j in range(u):
        column, row, total = R[j], F[j], along[others[j]]
        for q in range(c):
            total += column[q] * left[q]
        for i in range(j):
            total -= row[i] * more[i]
        more[j] = total / row[j]
    for j in range(u - 1, -1, -1):
        column, row = R[j], F[j]
        more[j] /= row[j]
        much = more[j]
        for i in range(j):
            more[i] -= row[i] * much
        unknown[j] += much
        for q in range(c):
            left[q] -= much * column[q]
    for q in range(c - 1, -1, -1):
        row = H[q]
        left[q] /= row[q]
        much = left[q]
        for p in range(q):
            left[p] -= row[p] * much
        multiplier[q] += much


@inner
def finish(here, f):
    """Write x and the slacks w of the level."""
    free, asks = marks(here, at.FREE), marks(here, at.ASKS)
    pinned, dependent = marks(here, at.PINNED), marks(here, at.KIND)
    lo, norm, x, w = vector(here, at.LO), vector(here, at.NORM), vector(here, at.X), vector(here, at.W)
    scale, along, z = vector(here, at.D), vector(here, at.BALANCE), vector(here, at.G)
    for j in range(ints(here, 0, at.HEAD)[at.N]):
        i = asks[j]
        if i >= 0 and pinned[j] >= 0:
            w[i], dependent[i] = norm[i] * x[j] - lo[i], 0
    for t in range(f):
        x[free[t]] += z[t]
        i = asks[free[t]]
        if i >= 0:
            w[i], dependent[i] = scale[t] * along[t], 0


@inner
def spans_all(here, last):
    """Whether the rows of the level, with those above whose side is decided, determine x with none of the others.

    Free rows alone then balance the implicit last level: the undecided ones need no multiplier there, nor a sign. This
    is so if the decided rows tell the variables that are not asked, nor held at a bound that is decided.
    """
    n, c = ints(here, 0, at.HEAD)[at.N], marks(here, at.CUT)[last]
    asks, pinned, pivot = marks(here, at.ASKS), marks(here, at.PINNED), marks(here, at.PIVOT)
    col, row_of, decided = marks(here, at.COL), marks(here, at.ROW_OF), marks(here, at.DECIDED)
    others, u = marks(here, at.QUEUE), integer(0)
    norm, B, F = vector(here, at.NORM), matrix(here, at.B), matrix(here, at.FACTOR)
    for j in range(n):
        if asks[j] < 0 and (pinned[j] < 0 or decided[pinned[j]] != DECIDED):
            if u > c or u == len(F):
                return False
            others[u], u = j, u + 1
    for a in range(u):
        for b in range(a + 1):
            F[a][b] = 0.0
    for q in range(c):
        i = pivot[q]
        if decided[i] != DECIDED:
            continue
        size = norm[i] * norm[i]
        for a in range(u):
            part = entry_of(i, others[a], col, row_of, norm, B) / size
            for b in range(a + 1 if part != 0.0 else 0):
                F[a][b] += part * entry_of(i, others[b], col, row_of, norm, B)
    told = vector(here, at.SHARE)
    for a in range(u):
        told[a] = F[a][a]
    clear = cholesky(F, F, u)
    for a in range(u):
        clear = clear and F[a][a] * F[a][a] > TOLD * told[a]
    return clear
