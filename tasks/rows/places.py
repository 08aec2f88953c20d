"""Where each part of a stack has its rows in the hierarchy."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hqp import Hierarchy

from ..base.checks import Array
from .embedding import Embedding
from .expansion import Expanded
from .row_writer import RowWriter
from .site import Site, Workspace
from .weights import Weights


class Places:
    """The site of every part of a stack, from the highest level down; limits claim theirs.

    Parameters
    ----------
    expanded : Expanded
    hierarchy : hqp.Hierarchy
    shared : Workspace
    rates : array, shape (levels, nv)
        See :class:`tasks.rows.site.Site`.

    Attributes
    ----------
    parts : list of (Part, Site)
    levels : list of int
        On which level each part is.
    first : array of int
        The number of the first row of each in the whole hierarchy.
    embedding : Embedding
    weights : Weights
    """

    def __init__(self, expanded: Expanded, hierarchy: Hierarchy, shared: Workspace, rates: Array) -> None:
        levels, unknowns, meant = expanded
        self.embedding, self.weights = Embedding(unknowns), Weights(shared.robot)
        self.parts: list[tuple[RowWriter, Site]] = []
        self.levels = [k for k, parts in enumerate(levels.parts) for _ in parts]
        for view, parts, rate in zip(hierarchy.levels, levels.parts, rates, strict=True):
            row = 0
            for part in parts:
                own = slice(row, row + part.size(shared.robot))
                row = own.stop
                A = None if view.A is None else self.embedding.of_joints(part, view.A[own])
                site = Site(shared, A, view.lower[own], view.upper[own], rate)
                part.claim(site)
                self.parts.append((part, site))
                self.weights.add(part, site, view.weights[own])
        self.first = np.cumsum([0, *(site.rows for _, site in self.parts)])[:-1]
        self._sites: dict[int, tuple[Site, ...]] = {id(part): (site,) for part, site in self.parts}
        for declared, means in meant.items():
            self._sites[declared] = tuple(site for part, site in self.parts if any(part is each for each in means))

    def claiming(self, which: Iterable[int] | None = None) -> list[int]:
        """The numbers of those, of all parts or of these, which claim joint limits."""
        asked = range(len(self.parts)) if which is None else which
        return [k for k in asked if type(self.parts[k][0]).claim is not RowWriter.claim]

    def bounds(self, part: RowWriter) -> tuple[Array, Array] | None:
        """Lower and upper bounds of a part (views; of one that stands for several, a copy), None if it is not here."""
        sites = self._sites.get(id(part))
        if sites is None:
            return None
        if len(sites) == 1:
            return sites[0].lower, sites[0].upper
        none = np.zeros(0)
        lower, upper = ([getattr(site, side) for site in sites] for side in ("lower", "upper"))
        return np.concatenate([none, *lower]), np.concatenate([none, *upper])

    def error(self, part: object) -> Array | None:
        """The error of a part as it was measured when rows were last filled (a view); None if loops do not keep it."""
        sites = self._sites.get(id(part), ())
        return sites[0].plain_error[0] if len(sites) == 1 and sites[0].plain_error else None
