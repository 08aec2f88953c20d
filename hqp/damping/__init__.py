"""Damped least squares at any level of a hierarchy: the rules for lambda, and the stages that solve it."""

from .rules import (
    DampingRule,
    ErrorDamping,
    FixedDamping,
    ManipulabilityDamping,
    NumericalFiltering,
    SingularValueDamping,
    as_rule,
)
from .staged import Staged, by_index, index_of, rules_of
from .telling import retold, told

__all__ = [
    "DampingRule",
    "ErrorDamping",
    "FixedDamping",
    "ManipulabilityDamping",
    "NumericalFiltering",
    "SingularValueDamping",
    "Staged",
    "as_rule",
    "by_index",
    "index_of",
    "retold",
    "rules_of",
    "told",
]
