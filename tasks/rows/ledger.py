"""A ledger of the live objects in the parts of a stack: whose they are, and what they were when rows were planned."""

from __future__ import annotations

from typing import Any

from ..base.live import Live, Watcher, reachable, watch_alone


class Ledger:
    """The live objects in the parts of a stack, by their ids.

    Attributes
    ----------
    kinds : set of type
        Their classes.
    """

    def __init__(self) -> None:
        self.kinds: set[type[Live]] = set()
        self._owners: dict[int, list[int]] = {}
        self._known: dict[int, dict[str, Any]] = {}

    def enter(self, k: int, part: Live, watcher: Watcher) -> None:
        """Keep all that is reachable from part k as it is now, and have somebody told of changes."""
        for held in reachable(part):
            watch_alone(held, watcher)
            self.keep(held)
            self.kinds.add(type(held))
            owners = self._owners.setdefault(id(held), [])
            if k not in owners:
                owners.append(k)

    def keep(self, part: Live) -> None:
        """Keep the attributes of an object as they are now."""
        self._known[id(part)] = dict(vars(part))

    def owners(self, part: Live) -> list[int]:
        """The numbers of the parts that it can be reached from."""
        return self._owners.get(id(part), [])

    def changes(self, part: Live) -> list[str]:
        """The attributes that are other objects than those kept; none where some came or went, or none has changed."""
        before, now = self._known.get(id(part), {}), vars(part)
        changed = [name for name, value in now.items() if before.get(name, self) is not value]
        return changed if len(now) == len(before) else []

    def holds_others(self, part: Live, names: list[str]) -> bool:
        """Whether other live objects can be reached from these attributes of it; from all, where none is named."""
        return any(True for _ in reachable([vars(part)[name] for name in names or vars(part)]))
