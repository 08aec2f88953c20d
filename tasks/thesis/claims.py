"""The claims that the thesis makes of its figures, and the criterion that decides each from a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from .run_result import RunResult

#: Largest tip error [mm] of a path that counts as followed.
FOLLOWED = 1.0
#: Share of the move with phi within a degree: from here on it counts as kept, as kept for the major part,
#: as kept now and then. Phi is off at the start, and correcting that takes up to a sixth of the move.
KEPT, MAJOR_PART, NOW_AND_THEN = 0.8, 0.5, 0.2


@dataclass(frozen=True)
class Claim:
    """A sentence of the text that a number can decide.

    Attributes
    ----------
    says : str
        In short.
    holds : callable
        RunResult -> bool: whether it holds for a run.
    of_tip : bool
        Whether it is a claim on the tip alone, decided by its error; otherwise by the share of phi, too.
    """

    says: str
    holds: Callable[[RunResult], bool] = field(repr=False)
    of_tip: bool = False


def _follows(found: RunResult) -> bool:
    return not found.stopped and found.tip_error_mm < FOLLOWED


FOLLOWS = Claim("the tip follows the path, the orientation is left to itself", _follows, of_tip=True)
SINGULAR = Claim(
    "unable to follow the path: singular, joint speeds extremely high", lambda found: not _follows(found), of_tip=True
)
OVERCOMES = Claim("task priority overcomes the singularity: the tip follows the path", _follows, of_tip=True)
NO_LONGER_SINGULAR = Claim("a fourth joint avoids the singular configurations", _follows, of_tip=True)
BOTH = Claim("both tasks met with maximum accuracy", lambda found: _follows(found) and found.phi_share >= KEPT)
MOSTLY = Claim(
    "both tasks met for the major part, the orientation lost towards the end",
    lambda found: _follows(found) and MAJOR_PART <= found.phi_share < KEPT,
)
NOT_THROUGHOUT = Claim(
    "the orientation is not attained throughout: both cannot be met together",
    lambda found: _follows(found) and found.phi_share < KEPT,
)
