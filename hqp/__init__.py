"""Lexicographic sequences of QPs: declare levels in order of priority, get the x that is optimal for all, with proof.

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

from typing import TYPE_CHECKING

__version__ = "0.2.0"

#: Former name -> present name; each warns, for one version.
_FORMER = {
    "ACCURACY": "backends.ACCURACY",
    "BACKENDS": "backends.BACKENDS",
    "BackendInfo": "backends.BackendInfo",
    "Cause": "certificate.Cause",
    "Counts": "solution.Counts",
    "FAMILIES": "problems.FAMILIES",
    "Family": "problems.Family",
    "LevelCertificate": "certificate.LevelCertificate",
    "LevelExplanation": "certificate.LevelExplanation",
    "LevelSolution": "solution.LevelSolution",
    "LexLSProblem": "lexls.Problem",
    "PartExplanation": "certificate.PartExplanation",
    "RegularisedSolution": "Solution",
    "RegularisedSolver": "Solver",
    "Relaxation": "solution.Relaxation",
    "StageCertificates": "Certificate",
    "read_lexls": "lexls.read",
    "solve_regularised": "solve",
    "write_lexls": "lexls.write",
}

if TYPE_CHECKING:
    from ._all import *  # noqa: F403
    from ._all import __all__ as __all__
else:

    def __getattr__(name: str) -> object:
        """Import everything at the first use of a name, so that the command starts at once and can be interrupted."""
        from importlib import import_module

        if name == "families":
            return import_module(".families", __name__)
        if name in _FORMER:
            import warnings
            from functools import reduce

            warnings.warn(f"hqp.{name} is hqp.{_FORMER[name]} now", DeprecationWarning, stacklevel=2)
            return reduce(getattr, _FORMER[name].split("."), import_module(__name__))
        if name == "__all__" or not name.startswith("_"):
            everything = import_module("._all", __name__)
            if name == "__all__" or name in everything.__all__:
                return globals().setdefault(name, getattr(everything, name))
            if name in globals():  # a module that came with it
                return globals()[name]
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__getattr__("__all__")})
