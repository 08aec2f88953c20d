"""Certificates, the proofs that a point is lexicographically optimal, and explanations, made from their multipliers."""

from .causes import Cause
from .certificate import Certificate, LevelCertificate, certify, first_failed
from .explanation import Explanation, LevelExplanation
from .hand_over import Handed, left_alone
from .parts import PartExplanation
from .reasons import explain
from .rows import RowStates, allowance, excess, pull, row_states
from .subspace import row_space, split

__all__ = [
    "Cause",
    "Certificate",
    "Explanation",
    "Handed",
    "LevelCertificate",
    "LevelExplanation",
    "PartExplanation",
    "RowStates",
    "allowance",
    "certify",
    "excess",
    "explain",
    "first_failed",
    "left_alone",
    "pull",
    "row_space",
    "row_states",
    "split",
]
