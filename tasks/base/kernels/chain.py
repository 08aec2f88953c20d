"""Runs many loops in one call: separate calls from Python would cost more than most loops take."""

from __future__ import annotations

from hqp.kernels.call import called
from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import ints


@stamp
@entry
def run_chain(here):
    """Run loops in turn. The table has their number, and for each its address and that of its table."""
    count = ints(here, 0, 1)[0]
    told = ints(here, 1, 2 * count)
    for k in range(count):
        called(told[2 * k], told[2 * k + 1])
    return 0
