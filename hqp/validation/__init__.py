"""Validation of the solvers: their answers compared with answers from another source.

* :mod:`.closed_forms`: random equality stacks in every rank case, against Eq. 3.17 and Eq. 4.8.
* :mod:`.conditioning`: the same where a singular value goes to zero, decade by decade.
* :mod:`.two_formulas`: Eq. 4.8 against Eq. 3.17, where they coincide and how far they differ.
* :mod:`.hierarchies`: random hierarchies with inequalities, conflicts and weights at every level, against the
  certificate and against each other.
* :mod:`.known`: hierarchies whose answers are known, by hand or because they were made for them.
"""

from ..backends.registry import ACCURACY
from .answer import KnownAnswer
from .closed_forms import FORMULAS, Report, merge, validate_case
from .conditioning import PLACES, SIGMAS, TARGETS, UNDECIDABLE, ZONES, Point, approach, zone
from .hierarchies import SIZES, Judgement, judge, summed
from .known import KNOWN, Finding, check
from .two_formulas import RELATIONS, Parting, compare, part

__all__ = [
    "ACCURACY",
    "FORMULAS",
    "KNOWN",
    "PLACES",
    "RELATIONS",
    "SIGMAS",
    "SIZES",
    "TARGETS",
    "UNDECIDABLE",
    "ZONES",
    "Finding",
    "Judgement",
    "KnownAnswer",
    "Parting",
    "Point",
    "Report",
    "approach",
    "check",
    "compare",
    "judge",
    "merge",
    "part",
    "summed",
    "validate_case",
    "zone",
]
