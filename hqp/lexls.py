"""Hierarchies in the text format of the test problems of LexLS, https://github.com/jrl-umi3218/lexls.

>>> import hqp
>>> hqp.lexls.write("hard.dat", hierarchy, solution=hqp.solve(hierarchy).x)  # doctest: +SKIP
>>> problem = hqp.lexls.read("hard.dat")  # doctest: +SKIP
>>> problem.hierarchy, problem.solution  # doctest: +SKIP

Five fields come first, in any order, each with its numbers on the next line:

=============  ======================================================================================================
``#HierType``  100: rows end with b, equalities; 200: with lower and upper; 210: with lower, upper and a guess of the
               side on which the row is active, 0 for none, 1 lower, 2 upper, 3 equality
``#nVar``      number of unknowns
``#nObj``      number of levels, at least one
``#nCtr``      rows of each level
``#ObjType``   of each level, 200: rows of A; 100, only for the first: bounds on variables, which are counted from 1
=============  ======================================================================================================

Then comes ``#OBJECTIVE k`` with the rows of level k, a line each, for k = 0, 1, ..., and then, where they are known,
``#SolGuess`` and ``#Solution``, a starting point and an optimum, n numbers each. Any other line that begins with # is
a comment. What follows the number of an objective is the name of the level; LexLS passes over it.

No number is infinite there. Bounds beyond 1e30, which no finite one of ours may be, and the words inf and -inf are
read as infinite, and infinite ones are written as 1e31, for LexLS knows no such words. A finite bound that is meant to
be out of reach, as 1e12 in its own files, stays what it is.
"""

from __future__ import annotations

from .files.lexls.problem import Problem
from .files.lexls.read import read
from .files.lexls.write import as_lexls, write

__all__ = ["Problem", "as_lexls", "read", "write"]
