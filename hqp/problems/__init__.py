"""Test problems: random hierarchies, seeded and reproducible, and families that break solvers.

>>> from hqp import Solver
>>> from hqp.problems import hierarchies
>>> solver = Solver()
>>> [solver.solve(hierarchy).certify().ok for hierarchy in hierarchies("infeasible top", 3)]
[True, True, True]
"""

from .families import FAMILIES, Family, hierarchies
from .random import CASES, SHAPES, Case, equality_cases, random_hierarchy, random_sides

__all__ = [
    "CASES",
    "FAMILIES",
    "SHAPES",
    "Case",
    "Family",
    "equality_cases",
    "hierarchies",
    "random_hierarchy",
    "random_sides",
]
