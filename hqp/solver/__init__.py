"""Solving: one hierarchy, the same structure again and again with warm start, or a batch on all cores."""

from .batch import Batch, BatchSolution
from .batch_solver import BatchSolver, solve_batch
from .once import solve
from .solver import DEFAULT_BACKEND, Solver

__all__ = ["DEFAULT_BACKEND", "Batch", "BatchSolution", "BatchSolver", "Solver", "solve", "solve_batch"]
