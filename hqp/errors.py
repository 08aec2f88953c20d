"""Exceptions: errors of the *input*.

Wrong input raises one of these, at once, and says where and what is allowed. What a solver makes
of a valid hierarchy is never an exception: it is a :class:`hqp.Status`.
"""

from __future__ import annotations

import reprlib


class HqpError(Exception):
    """Root of every exception that this package raises on purpose."""


class InvalidInput(HqpError, ValueError):
    """A number, a shape or a name that cannot mean anything; the message says which and why."""


class UnknownBackend(InvalidInput):
    """No backend of that name can run here; the message lists those which can."""


class Unsupported(InvalidInput):
    """The hierarchy is valid, but the chosen backend does not take it; the message names one that does."""


class InUse(HqpError, RuntimeError):
    """An object that serves one thread at a time was called by two; the message names it."""


class MissingPackage(HqpError, ImportError):
    """An optional package is not installed; the message says how to get it."""


def brief(value: object) -> str:
    """`value`, of any type, in short form for a message."""
    try:
        return reprlib.repr(value)
    except ValueError:  # an int of more digits than Python writes
        return f"a {type(value).__name__} too long to be written"
