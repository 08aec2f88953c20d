"""The record of a closed loop: trajectories, errors, active limits; saved to disk and loaded."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from dataclasses import field as made
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hqp import InvalidInput, Status
from hqp.checks import whole_number
from hqp.files.whole import arrays_of, write_arrays

from ..base.checks import Array
from ..robots.manipulability import Degrees
from ..robots.robot import Robot, as_robot
from .account import Account, Shortfall, account

#: The format in the head of a saved record; its number changes with the fields.
FORMAT = "hqp record 3"
#: Older formats: the first has no shortfalls, the second has no forces.
FORMER, UNFORCED = "hqp record 1", "hqp record 2"
#: Fields of a record: arrays, arrays or None, and dicts of arrays.
ARRAYS = ("t", "q", "v", "a", "pose", "checked_t", "ranks")
OPTIONAL = ("tau", "manipulability")
DICTS = ("errors", "active", "forces")


@dataclass(frozen=True)
class Stop:
    """Why a run ended early.

    Attributes
    ----------
    t : float
        When [s].
    reason : str
    diverged : bool
        Whether the motion left all bounds; otherwise the solver had no answer.
    """

    t: float
    reason: str
    diverged: bool


@dataclass(frozen=True, eq=False)
class Record:
    """A simulated motion, in read-only arrays: N ticks and the N + 1 states around them.

    Attributes
    ----------
    t : array, shape (N + 1,)
        Time [s].
    q, v : array, shape (N + 1, n)
        Joint positions [rad] and velocities [rad/s]; at velocity order v[k + 1] is the command of tick k.
    a : array, shape (N, n)
        Joint accelerations [rad/s^2] over each tick; at velocity order (v[k + 1] - v[k]) / dt; with a plant, the
        commanded ones.
    tau : array, shape (N, n), or None
        Joint torques [N m] for a at the beginning of each tick (Eq. 4.1); None if the robot cannot compute them. With
        :class:`tasks.Dynamics` in the stack, the commanded torques of the joints that have a motor.
    pose : array, shape (N + 1, ...)
        Pose of the tip, in the coordinates of the robot.
    manipulability : array, shape (N + 1,), or None
        Manipulability of the tip, as the robot measures it; None if it does not.
    errors : dict of arrays, shape (N + 1, rows)
        Name of a task -> its error, desired - actual.
    active : dict of arrays of int8, shape (N, n)
        Name of a joint limit, also on torques -> the :class:`hqp.Side` of each joint: -1 at its lower bound, 1 at its
        upper bound, 0 between, 2 where both bounds meet.
    status : tuple of hqp.Status, length N
    checked_t : array
        Times of the ticks that were put to the certificate [s].
    ranks : array of int, shape (len(checked_t), levels)
        Directions that each level of the stack fixed at those ticks, among those that the levels above
        left open; satisfied inequalities fix none.
    certified : int
        How many of the checked ticks the certificate accepts.
    stopped : Stop or None
        Why the run ended early; None for a run that went to its end.
    shortfalls : tuple of tuples of Shortfall, or None
        What each of the checked ticks could not meet, and what held it back; None in a file of an older format.
    unknowns : int or None
        Number of unknowns of the stack: joints, and with :class:`tasks.Dynamics` also forces; None in a record from an
        older file, where it is the number of joints.
    robot : Robot or None
        The simulated robot; None in a record from a file.
    forces : dict of arrays, shape (N, k, 3)
        Name of a contact -> commanded forces at its k points, along the axes of the world [N]; for contacts with one
        wrench and for loops, in the form of :class:`tasks.Step`. Empty without :class:`tasks.Dynamics`.
    """

    t: Array
    q: Array
    v: Array
    a: Array
    tau: Array | None
    pose: Array
    manipulability: Array | None
    errors: dict[str, Array]
    active: dict[str, NDArray[np.int8]]
    status: tuple[Status, ...]
    checked_t: Array
    ranks: NDArray[np.int64]
    certified: int
    stopped: Stop | None
    shortfalls: tuple[tuple[Shortfall, ...], ...] | None = None
    unknowns: int | None = None
    robot: Robot | None = None
    forces: dict[str, Array] = made(default_factory=dict)

    @property
    def checked(self) -> int:
        """How many ticks were put to the certificate."""
        return len(self.checked_t)

    @property
    def certified_share(self) -> float:
        """Share of the checked ticks which the certificate accepts; NaN if none was checked."""
        return self.certified / self.checked if self.checked else float("nan")

    @property
    def degrees(self) -> Degrees:
        """Degrees of manipulability and of redundancy of every level, shape (len(checked_t), levels).

        A level controls as many directions as its rank in the null space of the levels above (Eq. 3.7), and leaves the
        rest to those below (Eq. 3.8). They are directions of the unknowns: if forces of contacts are unknown too, of
        accelerations and forces together.
        """
        free = self.v.shape[1] if self.unknowns is None else self.unknowns
        return Degrees(self.ranks, free - np.cumsum(self.ranks, axis=1))

    @property
    def diverged_at(self) -> float | None:
        """When the motion left all bounds [s], or None."""
        return self.stopped.t if self.stopped and self.stopped.diverged else None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the record to a file, numpy's .npz without pickle; the file appears whole or not at all.

        Raises
        ------
        InvalidInput
            If the file has another suffix than .npz, or cannot be written.
        """
        # Names are free text and status an enumeration: both go into the head, as JSON.
        kinds = list(dict.fromkeys(self.status))
        head = {
            "format": FORMAT,
            "names": {field: list(getattr(self, field)) for field in DICTS},
            "status": [kind.value for kind in kinds],
            "certified": self.certified,
            "unknowns": self.unknowns,
            "stopped": None if self.stopped is None else asdict(self.stopped),
            "shortfalls": self.shortfalls and [[asdict(each) for each in tick] for tick in self.shortfalls],
        }
        arrays: dict[str, NDArray[Any]] = {
            "head": np.array(json.dumps(head)),
            "status": np.array([kinds.index(status) for status in self.status], dtype=np.uint8),
        }
        arrays |= {field: getattr(self, field) for field in ARRAYS}
        arrays |= {field: getattr(self, field) for field in OPTIONAL if getattr(self, field) is not None}
        arrays |= {f"{field} {i}": array for field in DICTS for i, array in enumerate(getattr(self, field).values())}
        write_arrays(path, arrays)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Record:
        """The record that :meth:`save` wrote, equal to the last bit.

        Raises
        ------
        InvalidInput
            If the file cannot be read, is not a record, or is damaged.
        """
        with arrays_of(path, "record") as members:
            head = json.loads(str(members["head"]))
            if head["format"] not in (FORMAT, FORMER, UNFORCED):
                raise ValueError(f"its format is {head['format']!r}; it must be {FORMAT!r}")
            if not isinstance(head["names"], dict):
                raise ValueError(f"its names are {head['names']!r}")
            arrays: dict[str, Any] = {field: members[field] for field in ARRAYS}
            arrays |= {field: members.get(field) for field in OPTIONAL}
            for field in DICTS:
                arrays[field] = {name: members[f"{field} {i}"] for i, name in enumerate(head["names"].get(field, []))}
            _check_numbers(arrays)
            kinds, unknowns = [Status(value) for value in head["status"]], head.get("unknowns")
            loaded = cls(
                **arrays,
                status=tuple(kinds[whole_number(place, "status")] for place in members["status"].tolist()),
                certified=whole_number(head["certified"], "certified"),
                stopped=None if head["stopped"] is None else Stop(**head["stopped"]),
                shortfalls=_shortfalls(head.get("shortfalls")),
                unknowns=None if unknowns is None else whole_number(unknowns, "unknowns", least=1),
            )
            _check_lengths(loaded)
            return loaded

    def explain(self) -> Account:
        """Explain the whole motion in a few lines: which level was not met, from when to when, and what held it back.

        Raises
        ------
        InvalidInput
            If no tick was put to the certificate, or the record is from a file of an older format.
        """
        if self.shortfalls is None:
            raise InvalidInput(f"a file of the format {FORMER!r} does not say what held the levels back")
        return account(
            self.checked_t, self.shortfalls, self.certified, None if self.stopped is None else self.stopped.reason
        )

    def save_html(self, path: str | os.PathLike[str], *, robot: Robot | None = None, rate: float = 30.0) -> None:
        """Write the motion as a self-contained HTML page, which plays in any browser without a network.

        Parameters
        ----------
        path : path
            The file of the page, such as ``"motion.html"``.
        robot : Robot, optional
            The robot to draw (default: the one that moved; needed for a record from a file).
        rate : float
            Pictures per second.

        Raises
        ------
        InvalidInput
            If there is no robot, it has other sizes than the one that moved, the file is not called .html or .htm, or
            it cannot be written.
        MissingPackage
            If viser is not installed.
        """
        from ..drawing.page import save_page

        drawn = self.robot if robot is None else as_robot(robot)
        if drawn is None:
            raise InvalidInput("a record from a file holds no robot; give save_html the robot that moved")
        save_page(path, drawn, self.t, self.q, rate)

    def __len__(self) -> int:
        """Number of ticks N."""
        return len(self.a)

    def __repr__(self) -> str:
        end = f", stopped: {self.stopped.reason}" if self.stopped else ""
        proof = f", {self.certified} of {self.checked} checked ticks certified" if self.checked else ""
        return f"Record({len(self)} ticks, t = {self.t[0]:g} .. {self.t[-1]:g} s{proof}{end})"


def _check_numbers(arrays: dict[str, Any]) -> None:
    """Refuse arrays that hold no numbers, and a motion without times; raises ValueError."""
    told = {name: arrays[name] for name in (*ARRAYS, *OPTIONAL) if arrays[name] is not None}
    told |= {f"{field} of {name!r}": array for field in DICTS for name, array in arrays[field].items()}
    for name, array in told.items():
        if array.dtype.kind not in "fi":
            raise ValueError(f"{name} is of {array.dtype}; it must be numbers")
    if told["t"].ndim != 1 or not len(told["t"]):
        raise ValueError(f"t has shape {told['t'].shape}; it must be (states,)")


def _check_lengths(record: Record) -> None:
    """Refuse arrays that are not of one motion: one entry a state, a tick or a checked tick; raises ValueError."""
    of = {
        "state": {"t": record.t, "q": record.q, "v": record.v, "pose": record.pose}
        | {"manipulability": record.manipulability}
        | {f"errors of {name!r}": own for name, own in record.errors.items()},
        "tick": {"a": record.a, "tau": record.tau, "status": record.status}
        | {f"{field} of {name!r}": own for field in DICTS[1:] for name, own in getattr(record, field).items()},
        "checked tick": {"ranks": record.ranks, "shortfalls": record.shortfalls},
    }
    counts = {"state": len(record.t), "tick": len(record.t) - 1, "checked tick": record.checked}
    for what, own in of.items():
        for name, values in own.items():
            if values is not None and len(values) != counts[what]:
                raise ValueError(f"{name} has {len(values)} entries; it must have {counts[what]}, one a {what}")
    if record.certified > record.checked:
        raise ValueError(f"certified = {record.certified}, but {record.checked} ticks were checked")


def _shortfalls(told: Any) -> tuple[tuple[Shortfall, ...], ...] | None:
    return None if told is None else tuple(tuple(Shortfall.of(each) for each in tick) for tick in told)
