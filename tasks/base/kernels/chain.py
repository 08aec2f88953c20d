"""Runs many loops by one call: from Python each call would cost more than most loops take."""

from __future__ import annotations

from hqp.kernels.call import called
from hqp.kernels.compile import entry, stamp
from hqp.kernels.memory import ints


@stamp
@entry
def run_chain(here):
    """How many loops, and the address of each with that of its table."""
    count = ints(here, 0, 1)[0]
    told = ints(here, 1, 2 * count)
    for k in range(count):
        called(told[2 * k], told[2 * k + 1])
    return 0
