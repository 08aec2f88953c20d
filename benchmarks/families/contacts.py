"""One tick of a robot that stands: a humanoid and a quadruped, balanced, at contact changes, and saturated.

Accelerations and contact forces: physics and limits above the centre of mass, the base, and a posture with least
forces. One family has joint torques as unknowns besides. States and contacts are data, see :mod:`benchmarks.motions`;
what was solved before is the tick before.
"""

from __future__ import annotations

from functools import partial

from ..motions.data import DRAWS, table
from .family import Family, Sample


def _sample(name: str, seed: int, draw: int) -> Sample:
    from ..motions.standing import standing

    return standing(name).sample(draw)


FAMILIES = tuple(
    Family(
        entry.group,
        entry.name,
        entry.about,
        partial(_sample, entry.name),
        feasible=True,
        draws=DRAWS,
        needs=entry.needs,
    )
    for entry in table()
    if entry.group == "contacts"
)
