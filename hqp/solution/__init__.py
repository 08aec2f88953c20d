"""The answer of a solver: x, its status, every level at x, and where damping relaxed a level."""

from .level import LevelSolution
from .relaxation import Relaxation
from .softening import Softened
from .solution import Solution
from .stages import Stages
from .status import NO_COUNTS, Counts, Status

__all__ = ["NO_COUNTS", "Counts", "LevelSolution", "Relaxation", "Softened", "Solution", "Stages", "Status"]
