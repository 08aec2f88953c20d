"""Independent joints: the connected components of the graph in which a row joins the joints that it moves.

Two arms in one controller are two components, unless a row has joints of both.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..robots.robot import Robot
from .plan import Plan, overridden
from .row_writer import RowWriter
from .site import Site

#: Level, first row, part, plan and site of a part.
Work = tuple[int, int, RowWriter, Plan, Site]


class Components(NamedTuple):
    """The finest partition of the joints for which each row has joints of one component only.

    Attributes
    ----------
    columns : array of int, shape (n,)
        The number of the component of every joint velocity: 0, 1, ... by their first joints.
    rows : array of int, shape (m,)
        That of every row; 0 if it has no joint.
    """

    columns: NDArray[np.int64]
    rows: NDArray[np.int64]

    @property
    def size(self) -> int:
        """How many there are."""
        return int(self.columns.max(initial=0)) + 1

    def touched(self, row: int, rows: int) -> NDArray[np.bool_]:
        """The joints that are in one component with some of these rows, shape (n,)."""
        return np.isin(self.columns, self.rows[row : row + rows])


def one_component(n: int, m: int) -> Components:
    """All joints and rows in one."""
    return Components(np.zeros(n, dtype=np.int64), np.zeros(m, dtype=np.int64))


def components(work: Iterable[Work], robot: Robot, m: int) -> Components:
    """The components of a stack of m rows, by what its parts say of their rows."""
    columns, first = np.arange(robot.nv), np.zeros(m, dtype=np.int64)  # `first`: a joint of every row
    for _, row, part, _, site in work:
        for i, own in enumerate(reached(part, site, robot)):
            joints = np.flatnonzero(own)
            if len(joints):
                first[row + i] = joints[0]
                together = np.isin(columns, columns[joints])
                columns[together] = columns[together].min()
    columns = np.unique(columns, return_inverse=True)[1]
    return Components(columns, columns[first])


def reached(part: RowWriter, site: Site, robot: Robot) -> NDArray[np.bool_]:
    """Which joint velocities may have a part in each row, shape (rows, nv)."""
    if site.A is None:
        return np.eye(robot.nv, dtype=bool)[part.variables(robot)]
    found = None if overridden(type(part), part.says) else part.reach(robot)
    return np.ones((site.rows, robot.nv), dtype=bool) if found is None else found
