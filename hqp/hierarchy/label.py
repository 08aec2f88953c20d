"""A label: the name of a row, given by the part that wrote it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias, overload

from ..checks import of_type
from ..errors import InvalidInput, brief
from .side import Side


@dataclass(frozen=True, slots=True)
class Label:
    """The name of a row in explanations.

    Parameters
    ----------
    part : str
        The part that the row belongs to, as in ``velocity limit``. Equality rows of one part are one cause.
    row : str
        The row itself, as in ``panda_joint4``.
    unit : str
        Unit of its slack, as in ``rad/s``.
    bound : callable, optional
        For a row that several limits share: gives the text in place of `part`, from the active side and the value of
        the bound there. Such rows are listed one by one even if they are equalities. A function of a
        module can be pickled, a lambda cannot; files keep none.
    place : str
        Where the row is, as in ``point 2``. Inequality rows of one part that have places are one cause, told by how
        many places push: ``friction, at 3 of 4 points``.

    Raises
    ------
    InvalidInput
        If a text is not a string, or `bound` cannot be called.

    Examples
    --------
    >>> Label("velocity limit", "panda_joint4", "rad/s").at(Side.UPPER, 2.6)
    'panda_joint4 velocity limit (upper)'
    """

    part: str
    row: str = ""
    unit: str = ""
    bound: Callable[[Side, float], str] | None = None
    place: str = ""

    def __post_init__(self) -> None:
        for what in ("part", "row", "unit", "place"):
            of_type(getattr(self, what), str, f"{what} of a label")
        if self.bound is not None and not callable(self.bound):
            raise InvalidInput(f"bound of a label = {brief(self.bound)} must be a function of side and value, or None")

    def part_at(self, side: Side, value: float) -> str:
        """The part that the row speaks for on this side, where its bound has this value."""
        if self.bound is None:
            return self.part
        return of_type(self.bound(side, value), str, f"what bound of label {self.part!r} returned")

    def at(self, side: Side, value: float) -> str:
        """The row and the side on which it is active, in words."""
        return in_words(self.part_at(side, value), self.row, side)


def in_words(part: str, row: str, side: Side) -> str:
    """An inequality row and its side."""
    return f"{row} {part} ({side_in_words(side)})".lstrip()


def side_in_words(side: Side) -> str:
    """``lower``, ``inactive``, ``upper`` or ``equal``."""
    return "equal" if side is Side.EQUALITY else side.name.lower()


#: The labels of some rows, or a function that makes them when they are read.
Labels: TypeAlias = "Iterable[Label] | Callable[[], Iterable[Label]]"


class LateLabels(Sequence[Label]):
    """Labels that are made, and checked, when first read: most hierarchies are solved and never explained.

    Parameters
    ----------
    make : callable
        Gives them. A copy by pickle has the labels themselves.
    m : int
        Rows.
    what : str
        For messages.
    """

    def __init__(self, make: Callable[[], Iterable[Label]], m: int, what: str) -> None:
        self._make, self._m, self._what = make, m, what

    @cached_property
    def _labels(self) -> tuple[Label, ...]:
        return _checked(self._make(), self._m, self._what)

    @overload
    def __getitem__(self, row: int) -> Label: ...
    @overload
    def __getitem__(self, row: slice) -> Sequence[Label]: ...
    def __getitem__(self, row: int | slice) -> Label | Sequence[Label]:
        return self._labels[row]

    def __len__(self) -> int:
        return self._m

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return tuple, (self._labels,)


def labels_of(value: Labels | None, m: int, what: str) -> Sequence[Label] | None:
    """A label for each of m rows, or None; InvalidInput that names `what` otherwise."""
    if value is None:
        return None
    return LateLabels(value, m, what) if callable(value) else _checked(value, m, what)


def _checked(value: Iterable[Label], m: int, what: str) -> tuple[Label, ...]:
    try:
        labels = None if isinstance(value, str) else tuple(value)
    except TypeError:
        labels = None
    if labels is None:
        raise InvalidInput(f"{what} = {brief(value)} must be a sequence of hqp.Label, one a row")
    for row, label in enumerate(labels):
        of_type(label, Label, f"{what}[{row}]")
    if len(labels) != m:
        raise InvalidInput(f"{what}: {len(labels)} for {m} rows; there must be one a row")
    return labels
