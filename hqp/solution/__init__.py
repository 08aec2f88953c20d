"""The answer of a solver: x, its status, every level at x, and where damping relaxed a level."""

from .relaxation import Relaxation
from .softening import Softened
from .solution import NO_COUNTS, Counts, LevelSolution, Solution, Stages, Status

__all__ = ["NO_COUNTS", "Counts", "LevelSolution", "Relaxation", "Softened", "Solution", "Stages", "Status"]
