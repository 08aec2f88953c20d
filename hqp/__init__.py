"""Strict task priorities: declare levels in order, get the x that honours that order exactly, with proof.

>>> from hqp import Hierarchy, Level, solve
>>> hierarchy = Hierarchy([
...     Level.bounds([-1.0, -1.0], [1.0, 1.0], name="limits"),
...     Level.equality([[1.0, 1.0]], [3.0], name="reach"),
... ])
>>> solution = solve(hierarchy)
>>> solution.x.round(6).tolist(), solution.certify().ok
([1.0, 1.0], True)
"""

from __future__ import annotations

import warnings
from typing import Any

from .backends.registry import ACCURACY, BACKENDS, BackendInfo, available_backends, backend_info
from .batch import Batch, BatchSolution, BatchSolver, solve_batch
from .certificate import Certificate, LevelCertificate, certify
from .damping import (
    DampingRule,
    ErrorDamping,
    FixedDamping,
    ManipulabilityDamping,
    NumericalFiltering,
    SingularValueDamping,
)
from .errors import HqpError, InUse, InvalidInput, MissingPackage, UnknownBackend, Unsupported
from .explanation import Cause, Explanation, LevelExplanation, PartExplanation
from .families import FAMILIES, Family
from .hierarchy import Hierarchy
from .io import load, save
from .label import Label
from .level import Level
from .lexls import LexLSProblem, read_lexls, write_lexls
from .nearest import nearest
from .relaxation import Relaxation
from .settings import Settings
from .side import Side
from .solution import Counts, LevelSolution, Solution, Status
from .solve import DEFAULT_BACKEND, Solver, solve

__version__ = "0.1.0"

__all__ = [
    "ACCURACY",
    "BACKENDS",
    "DEFAULT_BACKEND",
    "FAMILIES",
    "BackendInfo",
    "Batch",
    "BatchSolution",
    "BatchSolver",
    "Cause",
    "Certificate",
    "Counts",
    "DampingRule",
    "ErrorDamping",
    "Explanation",
    "Family",
    "FixedDamping",
    "Hierarchy",
    "HqpError",
    "InUse",
    "InvalidInput",
    "Label",
    "Level",
    "LevelCertificate",
    "LevelExplanation",
    "LevelSolution",
    "LexLSProblem",
    "ManipulabilityDamping",
    "MissingPackage",
    "NumericalFiltering",
    "PartExplanation",
    "Relaxation",
    "Settings",
    "Side",
    "SingularValueDamping",
    "Solution",
    "Solver",
    "Status",
    "UnknownBackend",
    "Unsupported",
    "available_backends",
    "backend_info",
    "certify",
    "load",
    "nearest",
    "read_lexls",
    "save",
    "solve",
    "solve_batch",
    "write_lexls",
]

#: What is no more, and what is there instead.
_RENAMED: dict[str, Any] = {
    "RegularisedSolution": Solution,
    "RegularisedSolver": Solver,
    "StageCertificates": Certificate,
    "solve_regularised": solve,
}


def __getattr__(name: str) -> Any:
    if name in _RENAMED:
        now = _RENAMED[name]
        warnings.warn(f"hqp.{name} is hqp.{now.__name__} now", DeprecationWarning, stacklevel=2)
        return now
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
