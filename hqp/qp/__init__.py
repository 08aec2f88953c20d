"""Flat QP solvers behind one small protocol, one file an adapter, imported when used."""

from __future__ import annotations

from importlib import import_module

from ..settings import Settings
from .problem import FlatQP, FlatResult, FlatSolver, Sizes

__all__ = ["FlatQP", "FlatResult", "FlatSolver", "Sizes", "make_flat_solver"]


def make_flat_solver(name: str, sizes: Sizes, settings: Settings) -> FlatSolver:
    """A persistent solver for QPs of these sizes: "proxsuite", "osqp" or "qpsolvers/NAME"."""
    module, _, solver = name.partition("/")
    flat: FlatSolver = import_module(f".{module}_adapter", __package__).make(solver, sizes, settings)
    return flat
