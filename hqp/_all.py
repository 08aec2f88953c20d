"""What ``hqp`` exports, all of it; see :mod:`hqp`."""

from __future__ import annotations

from . import lexls, problems
from .backends import available_backends, backend_info
from .certificate import Certificate, Explanation, certify
from .damping import (
    DampingRule,
    ErrorDamping,
    FixedDamping,
    ManipulabilityDamping,
    NumericalFiltering,
    SingularValueDamping,
)
from .errors import HqpError, InUse, InvalidInput, MissingPackage, UnknownBackend, Unsupported
from .files import load, save
from .hierarchy import Hierarchy, Label, Level, Side, nearest
from .settings import Settings
from .solution import Solution, Status
from .solver import DEFAULT_BACKEND, Batch, BatchSolution, BatchSolver, Solver, solve, solve_batch

__all__ = [
    "DEFAULT_BACKEND",
    "Batch",
    "BatchSolution",
    "BatchSolver",
    "Certificate",
    "DampingRule",
    "ErrorDamping",
    "Explanation",
    "FixedDamping",
    "Hierarchy",
    "HqpError",
    "InUse",
    "InvalidInput",
    "Label",
    "Level",
    "ManipulabilityDamping",
    "MissingPackage",
    "NumericalFiltering",
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
    "lexls",
    "load",
    "nearest",
    "problems",
    "save",
    "solve",
    "solve_batch",
]
