"""One tick of a robot at work: planar arms, a Panda, a UR5, and two humanoids, each in four characters.

``slow`` stays in reach and away from all limits, ``saturated`` is faster than the joints, ``singular`` comes to
singularities and leaves them, of one task or of two that begin to contradict each other, and ``infeasible`` asks for
what is out of reach, with tasks that contradict each other. At velocity order: joint limits above the tasks above a
posture. The motions are data, see :mod:`benchmarks.motions`; what was solved before is the tick before.
"""

from __future__ import annotations

from functools import partial

from ..motions.data import DRAWS, table
from .family import Family, Sample


def _sample(name: str, seed: int, draw: int) -> Sample:
    from ..motions.playback import motion

    return motion(name).sample(draw)


#: Robots with a floating base, which has no posture.
_FLOATING = ("g1", "talos")

FAMILIES = tuple(
    Family(
        entry.group,
        entry.name,
        entry.about,
        partial(_sample, entry.name),
        feasible=True,
        posture=not entry.name.startswith(_FLOATING),
        draws=DRAWS,
        needs=entry.needs,
    )
    for entry in table()
    if entry.group == "motion"
)
