"""Backends as data: names, what each can do, what it needs. Looked up without importing any of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.util import find_spec

from ..errors import UnknownBackend, brief
from ..settings import Settings
from .base import Backend

#: Relative accuracy in x that an accuracy class stands for. The class "none" promises nothing: use the certificate.
ACCURACY = {"exact": 1e-6, "first-order": 1e-3, "none": math.inf}


@dataclass(frozen=True, kw_only=True)
class BackendInfo:
    """One backend, before anything of it is imported.

    Attributes
    ----------
    name, summary : str
    module : str
        Where its ``make(name, settings)`` lives, relative to ``hqp.backends``.
    accuracy : {"exact", "first-order", "none"}
        Class of its answers after polish: 1e-6 relative or better, or 1e-3 at worst; or no promise, if there are
        hierarchies that it answers wrongly while it claims the optimum.
    inequalities
        Whether it takes inequality rows.
    lexicographic
        Whether it aims at the optimum of the hierarchy as given (Eq. 4.8 aims at that of another one).
    qp_solver : str
        The flat QP solver that it drives, if any.
    package : str
        Import name of the package it needs, if any beyond the core.
    install : str
        What to install to get it.
    """

    name: str
    summary: str
    module: str
    accuracy: str = "exact"
    inequalities: bool = True
    lexicographic: bool = True
    qp_solver: str = ""
    package: str = ""
    install: str = ""

    @property
    def installed(self) -> bool:
        """Whether the package it needs can be found (it is not imported)."""
        return not self.package or _found(self.package)


@cache
def _found(package: str) -> bool:
    return find_spec(package) is not None


# Solvers known to qpsolvers: name -> (import name, what to install, accuracy class after polish).
_QPSOLVERS = {
    "proxqp": ("proxsuite", "proxsuite", "exact"),
    "osqp": ("osqp", "osqp", "first-order"),
    "daqp": ("daqp", "daqp", "exact"),
    "quadprog": ("quadprog", "quadprog", "exact"),
    "clarabel": ("clarabel", "clarabel", "exact"),
    "piqp": ("piqp", "piqp", "exact"),
    "cvxopt": ("cvxopt", "cvxopt", "first-order"),
    "ecos": ("ecos", "ecos", "first-order"),
    "highs": ("highspy", "highspy", "first-order"),
    "jaxopt_osqp": ("jaxopt", "jaxopt", "first-order"),
    "qpalm": ("qpalm", "qpalm", "first-order"),
    "qpax": ("qpax", "qpax", "first-order"),
    "scs": ("scs", "scs", "first-order"),
    # Not tried by the authors, or not on every problem: no promise.
    "copt": ("coptpy", "coptpy", "none"),
    "gurobi": ("gurobipy", "gurobipy", "none"),
    "hpipm": ("hpipm_python", "hpipm-python", "none"),
    "kvxopt": ("kvxopt", "kvxopt", "none"),
    "mosek": ("mosek", "mosek", "none"),
    "nppro": ("nppro", "nppro", "none"),
    "pdhcg": ("pdhcg", "pdhcg", "none"),
    "pyqpmad": ("pyqpmad", "pyqpmad", "none"),
    "qpoases": ("qpoases", "qpoases", "none"),
    "qpswift": ("qpSWIFT", "qpSWIFT", "none"),
    "qtqp": ("qtqp", "qtqp", "none"),
    "sip": ("sip_qp_python", "sip-qp-python", "none"),
}

_BACKENDS = [
    BackendInfo(
        name="native",
        summary="the project's own: compiled, exact, warm",
        module="native",
        package="numba",
        install="numba",
    ),
    BackendInfo(
        name="pseudoinverse",
        summary="closed form, Eq. 3.17: the reference",
        module="pseudoinverse",
        inequalities=False,
    ),
    BackendInfo(
        name="pseudoinverse:joint",
        summary="closed form, Eq. 4.8: optimal for its own {J1} > {x = J2# h2}",
        module="pseudoinverse",
        inequalities=False,
        lexicographic=False,
    ),
    BackendInfo(
        name="cascade:proxsuite",
        summary="QPs by ProxQP, persistent and warm",
        module="cascade",
        qp_solver="proxsuite",
        package="proxsuite",
        install="proxsuite",
    ),
    BackendInfo(
        name="cascade:osqp",
        summary="QPs by OSQP, persistent and warm",
        module="cascade",
        accuracy="first-order",
        qp_solver="osqp",
        package="osqp",
        install="osqp",
    ),
    *(
        BackendInfo(
            name=f"cascade:qpsolvers/{solver}",
            summary=f"QPs by {solver}, set up anew each time",
            module="cascade",
            accuracy=accuracy,
            qp_solver=f"qpsolvers/{solver}",
            package=package,
            install=install,
        )
        for solver, (package, install, accuracy) in _QPSOLVERS.items()
    ),
    BackendInfo(
        name="daqp",
        summary="DAQP's own hierarchy; a level it cannot meet is met as if its rows had norm 1 and no weights",
        module="daqp",
        accuracy="none",
        package="daqp",
        install="daqp",
    ),
]

#: All backends by name, those that cannot run here included.
BACKENDS: dict[str, BackendInfo] = {info.name: info for info in _BACKENDS}


def available_backends() -> tuple[str, ...]:
    """Names of the backends that can run here, in the order of the registry.

    Examples
    --------
    >>> from hqp import available_backends
    >>> "native" in available_backends()
    True
    """
    return tuple(name for name, info in BACKENDS.items() if info.installed)


def backend_info(name: str) -> BackendInfo:
    """Look a backend up by name.

    Parameters
    ----------
    name : str
        One of ``hqp.backends.BACKENDS``.

    Raises
    ------
    UnknownBackend
        If there is none of that name, or its package is not installed; the message lists those
        that can run here.

    Examples
    --------
    >>> from hqp import backend_info
    >>> backend_info("native").accuracy, backend_info("pseudoinverse").inequalities
    ('exact', False)
    """
    info = BACKENDS.get(name) if isinstance(name, str) else None
    if info is None:
        raise UnknownBackend(f"unknown backend {brief(name)}; installed here: {', '.join(available_backends())}")
    if not info.installed:
        raise UnknownBackend(
            f"backend {name!r} needs the package {info.package!r} (pip install '{info.install}');"
            f" installed here: {', '.join(available_backends())}"
        )
    return info


def make_backend(name: str, settings: Settings, once: bool = False) -> Backend:
    """Import the backend's module, now, and make one; the native one that solves `once` is ready for what is usual."""
    from ..kernels.collector import collected_rarely

    info = backend_info(name)
    with collected_rarely():
        module = import_module(f".{info.module}", __package__)
        backend: Backend = (module.make_once if once else module.make)(info.name, settings)
    return backend
