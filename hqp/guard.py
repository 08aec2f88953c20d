"""A guard that admits one thread at a time: a second one gets an exception instead of wrong numbers."""

from __future__ import annotations

import os

from .errors import InUse


class Guard:
    """Lets one thread in. A second one does not wait: two threads on one object are a mistake; waiting would hide it.

    Use it as ``with guard: ...``. There is one key. Taking it from a list, and putting it back, are atomic and cost
    less than a lock; code that is called millions of times does the steps of :meth:`__enter__` and :meth:`__exit__`
    itself.

    Parameters
    ----------
    what : str
        What is guarded, for the message.
    """

    __slots__ = ("_pid", "_what", "give", "take")

    def __init__(self, what: str) -> None:
        keys = [None]
        self._what, self._pid = what, os.getpid()
        self.take, self.give = keys.pop, keys.append

    def __enter__(self) -> None:
        try:
            self.take()
        except IndexError:
            self.refuse()

    def __exit__(self, *_: object) -> None:
        self.give(None)

    def refuse(self) -> None:
        """Say that another thread is inside; but not to a child that was forked meanwhile, which has no such thread.

        Raises
        ------
        InUse
        """
        if self._pid == os.getpid():
            raise InUse(f"{self._what} is at work for another thread; give each its own, as by copy.deepcopy")
        self._pid = os.getpid()

    def __reduce__(self) -> tuple[type[Guard], tuple[str]]:
        return Guard, (self._what,)
