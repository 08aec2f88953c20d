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
from .regularisation import RegularisedSolver, solve_regularised
from .relaxation import RegularisedSolution, Relaxation, StageCertificates
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
    "RegularisedSolution",
    "RegularisedSolver",
    "Relaxation",
    "Settings",
    "Side",
    "SingularValueDamping",
    "Solution",
    "Solver",
    "StageCertificates",
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
    "solve_regularised",
    "write_lexls",
]
