"""Live attributes: changing one on an object in use takes effect at the next tick, or is refused.

A class derived from :class:`Live` declares its public attributes:

>>> class Spring(Live):
...     joint: str = structure()
...
...     @number
...     def stiffness(self, value: ArrayLike) -> Array:
...         return positive(value, "stiffness", unit="N m/rad")
...
...     def __init__(self, joint, stiffness):
...         self.joint, self.stiffness = joint, stiffness

A **number** is declared by the function that checks it, and may be set at any time. The value that the function returns
is kept (an array as a read-only copy), and every watcher is told. If a watcher, such as a controller in use, cannot
accept the new value, the change is refused and undone. A property with a setter behaves in the same way.

**Structure** is set once, by ``__init__``. The attributes of the class itself, such as methods, cannot be set either.

Attributes that a user's class sets in ``__init__`` without a declaration may be set at any time, and no watcher is
told. The same holds for names with a leading underscore. Any other name is refused as misspelt.

Values are kept in ``vars(self)``, so that reading them costs no more than in any class.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from functools import wraps
from inspect import signature
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NoReturn, Protocol, Self, TypeVar, overload
from warnings import warn
from weakref import ref

import numpy as np

from hqp import InvalidInput

from .checks import suggestion

Given = TypeVar("Given")
Kept = TypeVar("Kept")

#: Marks structure without a default.
NONE_GIVEN: Any = object()
#: Types of most attributes; they contain no live object.
HOLD_NOTHING = frozenset({np.ndarray, str, float, int, bool, type(None)})


class number(Generic[Given, Kept]):  # noqa: N801  # a decorator, like property
    """An attribute that may be set at any time; decorates ``check(self, value)``, which returns the value to keep.

    The function raises InvalidInput for values that are not allowed. It also runs in ``__init__``, where other
    attributes may not exist yet: conditions on several attributes belong in :meth:`Live._renew`.
    """

    def __init__(self, check: Callable[[Any, Given], Kept]) -> None:
        self.check = check
        self.__doc__ = check.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, part: None, owner: type) -> Self: ...
    @overload
    def __get__(self, part: object, owner: type) -> Kept: ...
    def __get__(self, part: object | None, owner: type) -> Self | Kept:
        """Called only while the object has no value."""
        if part is None:
            return self
        raise AttributeError(f"{owner.__name__} has no {self._name} yet")

    if TYPE_CHECKING:  # `Live.__setattr__` sets the value

        def __set__(self, part: object, value: Given) -> None: ...


def structure(default: Any = NONE_GIVEN) -> Any:
    """An attribute that is set once, by ``__init__`` or by a subclass: ``frame: str | None = structure()``."""
    return _Structure(default)


class _Structure:
    """An attribute that is set once; see :func:`structure`."""

    def __init__(self, default: Any) -> None:
        self._default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, part: object | None, owner: type) -> Any:
        """Called only while the object has no value of its own."""
        if self._default is not NONE_GIVEN:
            return self._default
        if part is None:
            return self
        raise AttributeError(f"{owner.__name__} has no {self._name} yet")


class Watcher(Protocol):
    """An object that is told when a live object changes, such as a controller."""

    def admit(self, part: Live, name: str) -> None:
        """Accept the changed attribute of a part, or refuse it.

        Raises
        ------
        InvalidInput
            If the watcher could not work with the new value. It is then called again, with the old value restored.
        """


def _sealing(begin: Callable[..., None]) -> Callable[..., None]:
    """An `__init__` that seals the object after its whole construction, including that of subclasses.

    A metaclass could do the same, but would not allow classes that are also a Protocol.
    """

    @wraps(begin)
    def __init__(self: Live, *args: Any, **kwargs: Any) -> None:  # noqa: N807
        inner = vars(self).get("_sealed") is False
        self._sealed = False
        try:
            begin(self, *args, **kwargs)
        finally:
            self._sealed = not inner

    return __init__


class Live:
    """Base class of objects whose attributes may be changed while a controller uses them; see :mod:`tasks.base.live`.

    Copies, by :mod:`copy` or pickle, have no watchers.
    """

    # Watchers, and what is kept beside an object, are in slots, not in the state: no copy takes them along, whatever
    # its __getstate__ returns.
    __slots__ = ("__dict__", "__weakref__", "_beside", "_watchers")

    _beside: threading.local
    _watchers: tuple[ref[Watcher], ...]
    _sealed: bool
    #: What to do instead of setting structure; the end of the error message.
    _instead: ClassVar[str] = "make a new one"
    _numbers: ClassVar[Mapping[str, Callable[[Any, Any], Any]]] = {}
    _structure: ClassVar[frozenset[str]] = frozenset()

    if not TYPE_CHECKING:  # type checkers see the one of `object`

        @_sealing
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if "__init__" in vars(cls):
            cls.__init__ = _sealing(cls.__init__)  # type: ignore[method-assign]
        if "label" in vars(cls) and "full_name" not in vars(cls):
            warn(f"{cls.__name__}.label is called full_name now", DeprecationWarning, stacklevel=2)
            cls.full_name = cls.label  # type: ignore[method-assign]
        numbers: dict[str, Callable[[Any, Any], Any]] = {}
        fixed: set[str] = set()
        for base in reversed(cls.__mro__):
            for name, value in vars(base).items():
                if isinstance(value, number | property | _Structure):  # a declaration replaces the base class's
                    numbers.pop(name, None)
                    fixed.discard(name)
                if isinstance(value, number):
                    numbers[name] = value.check
                elif isinstance(value, _Structure):
                    fixed.add(name)
        cls._numbers, cls._structure = numbers, frozenset(fixed)

    def full_name(self) -> str:
        """Class and name of the object, as in messages: ``PositionTask 'hand'``."""
        name = vars(self).get("name")
        return f"{type(self).__name__} {name!r}" if isinstance(name, str) and name else type(self).__name__

    def label(self) -> str:
        """Former name of :meth:`full_name`."""
        warn(f"{type(self).__name__}.label is {type(self).__name__}.full_name now", DeprecationWarning, stacklevel=2)
        return self.full_name()

    def _renew(self) -> None:
        """Check conditions on several attributes, and recompute what is derived from them; called after every change.

        Raises
        ------
        InvalidInput
            The change is then undone.
        """

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_"):
            object.__setattr__(self, name, value)
        elif not vars(self).get("_sealed"):
            check = self._numbers.get(name)
            object.__setattr__(self, name, value if check is None else _kept(check(self, value)))
        elif name in self._numbers or _settable(type(self), name):
            self._change(name, value)
        elif name in vars(self) and name not in self._structure:
            object.__setattr__(self, name, value)
        else:
            self._refuse(name)

    def __delattr__(self, name: str) -> None:
        own = name in vars(self) and name not in self._structure and name not in self._numbers
        if name.startswith("_") or own or not vars(self).get("_sealed"):
            object.__delattr__(self, name)
        elif name in self._numbers:
            raise InvalidInput(f"{self.full_name()}: {name} cannot be deleted; it may be set to another value")
        else:
            self._refuse(name)

    def _change(self, name: str, value: Any) -> None:
        """Set a number, or a property with a setter, as during construction; undone as a whole if it fails."""
        own = vars(self)
        before, own["_sealed"] = dict(own), False
        try:
            setattr(self, name, value)
            self._renew()
        except BaseException:
            self._restore(before)
            raise
        own["_sealed"] = True
        try:
            self._tell(name)
        except BaseException:
            self._restore(before)
            self._tell(name)
            raise

    def _restore(self, before: dict[str, Any]) -> None:
        for name in vars(self).keys() - before.keys():
            del vars(self)[name]
        vars(self).update(before)

    def _tell(self, name: str) -> None:
        for known in getattr(self, "_watchers", ()):
            watcher = known()
            if watcher is not None:
                watcher.admit(self, name)

    def _refuse(self, name: str) -> NoReturn:
        if name in self._structure:
            raise InvalidInput(f"{self.full_name()}: {name} is part of its structure, and stays; {self._instead}")
        if hasattr(type(self), name):
            raise InvalidInput(f"{self.full_name()}: {name} is given by its class, and stays; {self._instead}")
        parameter = signature(type(self)).parameters.get(name)
        if parameter is not None and parameter.kind is parameter.KEYWORD_ONLY:
            raise InvalidInput(f"{self.full_name()}: {name} is given when it is made, and stays; {self._instead}")
        known = sorted(other for other in vars(self).keys() | _data(type(self)) if not other.startswith("_"))
        raise InvalidInput(f"{self.full_name()}: there is no attribute {name!r}{suggestion(name, known)}")

    def __getstate__(self) -> dict[str, Any]:
        return dict(vars(self))


def beside(part: Live) -> threading.local:
    """What this thread keeps beside an object, in attributes of any name; it goes with the object, and no copy has it.

    A mapping with weak keys would not do: what is kept may hold the object itself.
    """
    try:
        return part._beside
    except AttributeError:
        part._beside = threading.local()
        return part._beside


def watch(root: object, watcher: Watcher) -> None:
    """Tell a watcher of every change from now on in all objects reachable from a part; holds the watcher weakly.

    Objects that become reachable only by a later change must be watched by another call.
    """
    for part in reachable(root):
        watch_alone(part, watcher)


def watch_alone(part: Live, watcher: Watcher) -> None:
    """Tell a watcher of every change in this one object from now on."""
    others = (known for known in getattr(part, "_watchers", ()) if known() is not None and known() is not watcher)
    part._watchers = (*others, ref(watcher))


def reachable(root: object) -> Iterator[Live]:
    """A live object and all live objects it holds, also in tuples, lists and dicts, each once."""
    seen: set[int] = set()
    rest: list[object] = [root]
    while rest:
        value = rest.pop()
        if type(value) in HOLD_NOTHING:
            continue
        if isinstance(value, Live):
            if id(value) not in seen:
                seen.add(id(value))
                yield value
                rest.extend(reversed(list(vars(value).values())))
        elif isinstance(value, tuple | list):
            rest.extend(reversed(value))
        elif isinstance(value, Mapping):
            rest.extend(reversed(list(value.values())))


def _kept(value: Any) -> Any:
    """The value; an array as a read-only copy."""
    if isinstance(value, np.ndarray) and (value.flags.writeable or not value.flags.owndata):
        value = value.copy()
        value.flags.writeable = False
    return value


def _data(cls: type) -> set[str]:
    """The names of all data attributes of a class."""
    own = {name: value for base in reversed(cls.__mro__) for name, value in vars(base).items()}
    return {name for name, value in own.items() if not (callable(value) or isinstance(value, classmethod))}


def _settable(cls: type, name: str) -> bool:
    """Whether the class has a property of this name with a setter."""
    found = getattr(cls, name, None)
    return isinstance(found, property) and found.fset is not None
