"""What anybody may give by mistake: values of every wrong type, shape and size, each made anew when asked for."""

from __future__ import annotations

import datetime
import itertools
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from hqp import Hierarchy, Level, Settings, Status
from tasks import PlanarArm, PositionTask


class Mute:
    """It does not even tell its name."""

    def __repr__(self) -> str:
        raise RuntimeError("no name")


class Refusing:
    """Whatever is asked of it is an error."""

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise TypeError("no array")

    def __float__(self) -> float:
        raise TypeError("no float")

    def __iter__(self) -> Iterator[Any]:
        raise TypeError("no iteration")

    def __len__(self) -> int:
        raise TypeError("no length")

    def __bool__(self) -> bool:
        raise TypeError("no truth")

    def __eq__(self, other: object) -> bool:
        raise TypeError("no comparison")

    def __hash__(self) -> int:
        raise TypeError("no hash")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError("no attributes")


def read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array


def failing(*_: Any, **__: Any) -> Any:
    raise RuntimeError("it fails")


#: No whole number between 20 and 2^31, and no length of time between 20 and 1e15, is among them: these work, and long.
JUNK: dict[str, Callable[[], Any]] = {
    **{
        repr(value): (lambda value=value: value)
        for value in (
            None, True, False, 0, 1, -1, 2, 3, 7, 2**31, 2**63, 2**64, 0.0, -0.0, 0.5, 1.0, -1.0, 2.5, 1e-300, 1e-12,
            1e16, 1e155, 1e-155, 1e300, -1e300, float("nan"), float("inf"), float("-inf"), 1j, "", "a", "x", "velocity",
            "world", "native", "tip", "\x00", "\ud800", "[red]", b"", b"abc", (), ..., NotImplemented, range(3),
            Decimal("0.5"), Fraction(1, 3), int, ValueError, Status.OPTIMAL, datetime.date(2026, 1, 1), slice(3), len,
        )
    },
    "10**400": lambda: 10**400,
    "-10**400": lambda: -(10**400),
    "10**5000": lambda: 10**5000,
    "nowhere": lambda: Path("nowhere"),
    "object": object,
    "Mute": Mute,
    "Refusing": Refusing,
    "namespace": lambda: SimpleNamespace(nq=3, nv=3, name="nobody", structure=None),
    "lambda": lambda: lambda *_: None,
    "lambda of 3": lambda: lambda t: (np.zeros(3),) * 3,
    "lambda of NaN": lambda: lambda t: (np.full(3, np.nan),) * 3,
    "lambda of text": lambda: lambda *_: "abc",
    "failing": lambda: failing,
    "[]": list,
    "{}": dict,
    "set": lambda: {1.0, 2.0, 3.0},
    "{'a': 1}": lambda: {"a": 1.0},
    "{0: 1.0}": lambda: {0: 1.0},
    "{0.5: None}": lambda: {0.5: None},
    "[None]": lambda: [None],
    "['a']": lambda: ["a"],
    "[b'a']": lambda: [b"a"],
    "[object]": lambda: [object()],
    "ragged": lambda: [[1.0], [1.0, 2.0]],
    "[0.5, 0.2]": lambda: [0.5, 0.2],
    "[0.5, 0.2, 0.1]": lambda: [0.5, 0.2, 0.1],
    "tuple of 4": lambda: (0.5, 0.2, 0.1, 0.1),
    "[nan] * 3": lambda: [float("nan")] * 3,
    "[inf] * 3": lambda: [float("inf")] * 3,
    "[1e300] * 3": lambda: [1e300] * 3,
    "[10**400] * 3": lambda: [10**400] * 3,
    "[True] * 3": lambda: [True] * 3,
    "generator": lambda: (x for x in (0.1, 0.2, 0.3)),
    "iterator": lambda: iter(()),
    "pairs": lambda: [("link0", "link3")],
    "zip": lambda: zip("ab", "cd", strict=True),
    "chain": lambda: itertools.chain("ab"),
    "bytearray": lambda: bytearray(b"ab"),
    "memoryview": lambda: memoryview(b"abcdefgh"),
    "zeros 2": lambda: np.zeros(2),
    "zeros 3": lambda: np.zeros(3),
    "read-only 3": lambda: read_only(np.full(3, 0.1)),
    "float32 3": lambda: np.full(3, 0.1, dtype=np.float32),
    "float16 3": lambda: np.full(3, 6e4, dtype=np.float16),
    "longdouble 3": lambda: np.full(3, np.longdouble("1e4000")),
    "big-endian 3": lambda: np.full(3, 0.1, dtype=">f8"),
    "strided 3": lambda: np.full(6, 0.1)[::2],
    "nan 3": lambda: np.full(3, np.nan),
    "inf 3": lambda: np.full(3, np.inf),
    "1e300 3": lambda: np.full(3, 1e300),
    "-1 3": lambda: np.full(3, -1.0),
    "ints 3": lambda: np.arange(3),
    "uint64 3": lambda: np.full(3, 2**64 - 1, dtype=np.uint64),
    "bools 3": lambda: np.array([True, False, True]),
    "complex 3": lambda: np.ones(3) * 1j,
    "dates 3": lambda: np.zeros(3, dtype="M8[s]"),
    "texts 3": lambda: np.array(["a", "b", "c"]),
    "bytes 3": lambda: np.array([b"a", b"b", b"c"]),
    "void": lambda: np.zeros(3, dtype=[("a", "f8"), ("b", "i4")]),
    "masked 3": lambda: np.ma.masked_array([1.0, 2.0, 3.0], [False, True, False]),
    "objects 3": lambda: np.array([0.1, 0.2, 0.3], dtype=object),
    "Nones 3": lambda: np.array([None] * 3, dtype=object),
    "0-d": lambda: np.array(0.5),
    "0-d nan": lambda: np.array(np.nan),
    "0-d object": lambda: np.array(None, dtype=object),
    "float32": lambda: np.float32(0.5),
    "int8": lambda: np.int8(1),
    "bool_": lambda: np.bool_(True),
    "str_": lambda: np.str_("velocity"),
    "datetime64": lambda: np.datetime64("2026-01-01"),
    "(0,)": lambda: np.zeros(0),
    "(0, 3)": lambda: np.zeros((0, 3)),
    "(3, 0)": lambda: np.zeros((3, 0)),
    "(1,)": lambda: np.ones(1),
    "(1, 3)": lambda: np.ones((1, 3)),
    "(2, 3)": lambda: np.ones((2, 3)),
    "(1, 1, 1)": lambda: np.ones((1, 1, 1)),
    "(2, 3, 3)": lambda: np.ones((2, 3, 3)),
    "eye 2": lambda: np.eye(2),
    "eye 3": lambda: np.eye(3),
    "eye 4": lambda: np.eye(4),
    "Fortran 3": lambda: np.asfortranarray(np.arange(9.0).reshape(3, 3)),
    "1e300 (3, 3)": lambda: np.full((3, 3), 1e300),
    "nan (3, 3)": lambda: np.full((3, 3), np.nan),
    "random": lambda: np.random.default_rng(0),
    "level": lambda: Level.equality([[1.0, 0.0, 0.0]], [0.5]),
    "hierarchy": lambda: Hierarchy([Level.equality([[1.0, 0.0, 0.0]], [0.5])]),
    "settings": Settings,
    "arm": lambda: PlanarArm([0.5, 0.4]),
    "task": lambda: PositionTask([0.5, 0.2], gain=1.0),
    "stack": lambda: PositionTask([0.5, 0.2], gain=1.0) >> PositionTask([0.5, 0.2], gain=1.0, name="b"),
}  # fmt: skip
