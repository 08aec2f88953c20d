"""One thread at a time: who comes while another is inside is told so, instead of both being given wrong numbers."""

from __future__ import annotations

import os

from .errors import InUse


class Guard:
    """Lets one thread in. It is not waited for: two threads on one object are a mistake, and a wait would hide it.

    There is one key. Taking it from a list, and putting it back, are steps that no other thread can come between, and
    cost less than a lock::

        try:
            guard.take()
        except IndexError:
            guard.refuse()
        try:
            ...
        finally:
            guard.give(None)

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
