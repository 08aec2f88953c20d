"""The safe method alone, as a loop: in a folder of its own, so that it is compiled anew with its own sources only."""

from __future__ import annotations

from hqp.kernels import layout as at
from hqp.kernels.active_set import active_set
from hqp.kernels.compile import entry, stamp
from hqp.kernels.dual import NEVER
from hqp.kernels.memory import given, ints, marks, vector
from hqp.kernels.orthogonal import length
from hqp.kernels.solver import ROUND_OFF, levels_that_count, load


@stamp
@entry
def safe_method(here, numbers):
    """Solve the hierarchy at this address from ``x`` by the safe method and nothing else."""
    head, option = ints(here, 0, at.HEAD), vector(here, at.OPTION)
    given(here, numbers)
    head[at.ITERATIONS], head[at.DEADLINE] = 0, NEVER
    load(here, False, True)
    last = levels_that_count(here)
    option[at.BLUR] = ROUND_OFF / option[at.TOL] * length(vector(here, at.X0), head[at.N])
    head[at.OUTCOME], head[at.LEVEL] = active_set(here, last, 0)
    side, told = marks(here, at.SIDE), ints(head[at.SIDES], 0, head[at.ROWS])
    for i in range(head[at.ROWS]):
        told[i] = side[i]
    return last
