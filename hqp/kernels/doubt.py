"""Ranks that could be others: rows that count as dependent, of which round-off alone would leave less.

Where limits saturate, rows that depend on others in exact arithmetic do so up to round-off, magnified by the condition
of the others. Then the rank is arbitrary, but what follows from it for the levels below is not: the certificate has to
agree.
"""

from __future__ import annotations

from . import layout as at
from .compile import inner
from .memory import ints, marks, vector

#: What round-off leaves of a row that depends on others, at most, where these are well conditioned.
SHARPEST = 2e-12


@inner
def note_doubt(here, begin, end):
    """Note if more than round-off is left of one of the dependent rows, at these places of the list of rows."""
    head, ids = ints(here, 0, at.HEAD), marks(here, at.IDS)
    lengths, norm = vector(here, at.LENGTHS), vector(here, at.NORM)
    for r in range(begin, end):
        if lengths[r] > SHARPEST * norm[ids[r]]:
            head[at.DOUBT] = 1
