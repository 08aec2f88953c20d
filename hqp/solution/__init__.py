"""The answer of a solver: x, its status, every level at x, and where damping relaxed a level."""

from .relaxation import Relaxation
from .solution import NO_COUNTS, Counts, LevelSolution, Solution, Stages, Status

__all__ = ["NO_COUNTS", "Counts", "LevelSolution", "Relaxation", "Solution", "Stages", "Status"]
