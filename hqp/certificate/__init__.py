"""The proof that a point is lexicographically optimal, its multipliers, and what they explain."""

from .certificate import Certificate, LevelCertificate, certify
from .explanation import Cause, Explanation, LevelExplanation, PartExplanation, explain
from .rows import RowStates, allowance, excess, pull, row_states
from .subspace import row_space, split

__all__ = [
    "Cause",
    "Certificate",
    "Explanation",
    "LevelCertificate",
    "LevelExplanation",
    "PartExplanation",
    "RowStates",
    "allowance",
    "certify",
    "excess",
    "explain",
    "pull",
    "row_space",
    "row_states",
    "split",
]
