"""The thesis's arms on their paths: joint limits above the position of the tip above the orientation.

At acceleration order, so that the bounds follow from velocities as well. Besides, priorities exchanged, and the tip
alone with its manipulability. States are data, see :mod:`benchmarks.motions`; targets follow from the time.
"""

from __future__ import annotations

from functools import partial

from ..motions.data import DRAWS, table
from .family import Family, Sample


def _sample(name: str, seed: int, draw: int) -> Sample:
    from ..motions.playback import thesis

    return thesis(name).sample(draw)


FAMILIES = tuple(
    Family(entry.group, entry.name, entry.about, partial(_sample, entry.name), feasible=True, draws=DRAWS)
    for entry in table()
    if entry.group == "thesis"
)
