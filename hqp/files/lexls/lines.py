"""The lines of a text file; every error message names the line number."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from ...checks import LARGEST_COUNT, spelled_number
from ...errors import brief
from ...hierarchy import LARGEST
from .problem import HEADER, POINTS

_OBJECTIVE = "#OBJECTIVE"
_COUNT = re.compile(r"\d{1,10}", re.ASCII)


class Lines:
    """Fields, and lines of numbers between them; comments and blank lines are passed over.

    Attributes
    ----------
    number : int
        Of the line that was read last, counted from 1.
    field : str or None
        The field that was read last; None at the end of the file.
    """

    def __init__(self, lines: Iterable[bytes]) -> None:
        self._lines = iter(lines)
        self.number = 0
        self.field: str | None = None

    def next_field(self, expected: str) -> None:
        """Go to the next field, or to the end of the file."""
        self.field = self._next()
        if self.field is not None and not self.field.startswith("#"):
            raise self.fault(brief(self.field), expected)

    def words(self, expected: str) -> list[str]:
        """What stands on the next line, which is no field."""
        text = self._next()
        if text is None or text.startswith("#"):
            raise self.fault(named(text), expected)
        return text.partition("#")[0].split()

    def count(self, word: str, expected: str, least: int = 0, most: int = LARGEST_COUNT) -> int:
        """`word` as a whole number between `least` and `most`."""
        if not (_COUNT.fullmatch(word) and least <= int(word) <= most):
            raise self.fault(brief(word), expected)
        return int(word)

    def real(self, word: str, what: str) -> float:
        """`word` as a finite number."""
        value = spelled_number(word)
        if value is None or not abs(value) <= LARGEST:
            raise self.fault(f"{what} = {brief(word)}", f"a finite number of at most {LARGEST:g} in size")
        return value

    def bound(self, word: str, what: str) -> float:
        """`word` as a bound: a number, which may be infinite."""
        value = spelled_number(word)
        if value is None or math.isnan(value):
            raise self.fault(f"{what} = {brief(word)}", "a number, or inf or -inf")
        return value if abs(value) <= LARGEST else math.copysign(math.inf, value)

    def fault(self, found: str, expected: str, number: int | None = None) -> ValueError:
        """What is wrong with the line that was read last, or with line `number`."""
        return ValueError(f"line {self.number if number is None else number}: found {found}; expected {expected}")

    def _next(self) -> str | None:
        for line in self._lines:
            self.number += 1
            try:
                text = line.decode("utf-8-sig" if self.number == 1 else "utf-8").strip()
            except UnicodeDecodeError as error:
                raise self.fault(f"the byte 0x{error.object[error.start]:02x}", "UTF-8 text") from None
            if not text.startswith("#"):
                if text:
                    return text
                continue
            squeezed = "".join(text.split())
            if squeezed in HEADER + POINTS:
                return squeezed
            if squeezed.startswith(_OBJECTIVE):
                return text
        return None


def named(field: str | None) -> str:
    """A field as messages call it."""
    return "the end of the file" if field is None else brief(field)
