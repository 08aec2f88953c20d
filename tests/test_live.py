"""Live attributes: what may be set is checked, kept read-only and told; all else is refused by name."""

from __future__ import annotations

import copy
import gc
import pickle
from collections.abc import Callable
from typing import Any, ClassVar, Protocol

import numpy as np
import pytest
from numpy.typing import ArrayLike

from hqp import InvalidInput
from tasks.base.checks import Array, positive, positive_scalar
from tasks.base.live import Live, number, reachable, structure, watch


class Spring(Live):
    """A number, one more that is tied to it, what is derived from both, structure, and a property."""

    plain: ClassVar[bool] = False
    name: str = structure()
    rows: int | None = structure(None)

    @number
    def stiffness(self, value: ArrayLike) -> Array:
        """K."""
        return positive(value, f"{self.full_name()}: stiffness")

    @number
    def least(self, value: float) -> float:
        return positive_scalar(value, f"{self.full_name()}: least")

    def __init__(self, stiffness: ArrayLike, *, least: float = 1e-3, name: str = "spring") -> None:
        self.name = name
        self.stiffness, self.least = stiffness, least  # type: ignore[assignment]
        self._renew()

    def _renew(self) -> None:
        if (self.stiffness < self.least).any():
            raise InvalidInput(f"{self.full_name()}: stiffness = {self.stiffness} is below least = {self.least}")
        self._square = self.stiffness**2

    @property
    def compliance(self) -> Array:
        return 1.0 / self.stiffness

    @compliance.setter
    def compliance(self, value: ArrayLike) -> None:
        self.stiffness = 1.0 / np.asarray(value)

    @property
    def square(self) -> Array:
        return self._square

    def energy(self, x: float) -> float:
        return float(0.5 * self.stiffness * x**2)


class Two(Live):
    """Holds others, in a tuple and in a dict."""

    def __init__(self, *springs: Spring, **others: Spring) -> None:
        self._springs, self._others = springs, others


class Ledger:
    """A watcher that keeps what it is told, and refuses what is stiffer than it can take."""

    def __init__(self, most: float = np.inf) -> None:
        self.most, self.told, self.taken = most, list[Live](), list[Any]()

    def admit(self, part: Live, name: str) -> None:
        assert isinstance(part, Spring)
        self.told.append(part)
        if (part.stiffness > self.most).any():
            raise InvalidInput(f"{part.full_name()}: stiffness = {part.stiffness} must be at most {self.most}")
        self.taken.append(part.stiffness.tolist())


def test_a_number_is_checked_kept_read_only_and_told() -> None:
    given = np.array([1.0, 2.0])
    spring, ledger = Spring(3.0), Ledger()
    watch(spring, ledger)
    spring.stiffness = given
    given[:] = 5.0
    assert spring.stiffness.tolist() == [1.0, 2.0]
    assert spring.square.tolist() == [1.0, 4.0]
    assert ledger.taken == [[1.0, 2.0]]
    with pytest.raises(ValueError, match="read-only"):
        spring.stiffness[0] = 7.0
    with pytest.raises(InvalidInput, match="stiffness"):
        spring.stiffness = -1.0
    assert ledger.taken == [[1.0, 2.0]]
    assert spring.stiffness.tolist() == [1.0, 2.0]


def test_numbers_are_read_from_the_object_itself() -> None:
    spring = Spring(3.0)
    assert vars(spring)["stiffness"] is spring.stiffness
    assert Spring.stiffness.__doc__ == "K."
    with pytest.raises(AttributeError, match="stiffness"):
        _ = Spring.__new__(Spring).stiffness


def test_what_a_watcher_refuses_is_as_if_never_set() -> None:
    spring, easy, strict = Spring(3.0), Ledger(), Ledger(10.0)
    watch(spring, easy)
    watch(spring, strict)
    before = dict(vars(spring))
    for change in lambda: setattr(spring, "stiffness", 11.0), lambda: setattr(spring, "compliance", 0.01):
        with pytest.raises(InvalidInput, match="at most 10"):
            change()
        assert all(vars(spring)[name] is value for name, value in before.items())
        assert vars(spring).keys() == before.keys()
        assert easy.taken[-1] == strict.taken[-1] == 3.0
    spring.compliance = 0.2
    assert easy.taken[-1] == strict.taken[-1] == pytest.approx(5.0)


def test_what_ties_numbers_takes_a_change_back() -> None:
    spring, ledger = Spring(3.0, least=1.0), Ledger()
    watch(spring, ledger)
    for name, value in ("stiffness", 0.5), ("least", 4.0), ("compliance", 2.0):
        with pytest.raises(InvalidInput, match="below least"):
            setattr(spring, name, value)
    assert (spring.stiffness, spring.least, spring.square) == (3.0, 1.0, 9.0)
    assert not ledger.told


REFUSED: list[tuple[str, str]] = [
    ("name", r"Spring 'spring': name is part of its structure, .*; make a new one"),
    ("rows", r"rows is part of its structure"),
    ("plain", r"plain is given by its class"),
    ("energy", r"energy is given by its class"),
    ("square", r"square is given by its class"),
    ("stifness", r"no attribute 'stifness'; did you mean 'stiffness'"),
    ("plian", r"no attribute 'plian'; did you mean 'plain'"),
    ("complience", r"no attribute 'complience'; did you mean 'compliance'"),
]


@pytest.mark.parametrize(("name", "message"), REFUSED)
def test_all_else_is_refused_by_name(name: str, message: str) -> None:
    spring, ledger = Spring(3.0), Ledger()
    watch(spring, ledger)
    with pytest.raises(InvalidInput, match=message):
        setattr(spring, name, 2)
    with pytest.raises(InvalidInput, match=name):
        delattr(spring, name)
    assert not ledger.told


def test_numbers_are_not_deleted() -> None:
    spring = Spring(3.0)
    with pytest.raises(InvalidInput, match="stiffness cannot be deleted"):
        del spring.stiffness
    assert spring.stiffness == 3.0


class Own(Spring):
    """A user's class: attributes of its own before and after those of its base, and structure given by the class."""

    rows = 4
    height = 0.5

    def __init__(self) -> None:
        self.before = 1.0
        super().__init__(3.0)
        self.after = {"a": 1}


def test_what_a_class_of_ones_own_puts_into_itself_is_free() -> None:
    own = Own()
    own.before, own.after, own._private = 2.0, {}, 1
    assert (own.before, own.after, own.rows) == (2.0, {}, 4)
    own.stiffness = 4.0
    del own.before
    for name, message in ("rows", "structure"), ("height", "class"), ("befor", "no attribute"), ("afer", "'after'"):
        with pytest.raises(InvalidInput, match=message):
            setattr(own, name, 1)


class Loud(Protocol):
    def shout(self) -> str: ...


class Mixin:
    def __init__(self, word: str) -> None:
        self.word = word


class Bare(Live, Mixin, Loud):
    """Without an `__init__`, beside a class that has one, and a protocol."""

    height = structure(0.5)

    def shout(self) -> str:
        return self.word.upper()


class Failing(Spring):
    def __init__(self) -> None:
        self.early = 1
        raise KeyError("early")


def test_any_construction_ends_sealed() -> None:
    bare = Bare("a")
    assert bare.shout() == "A"
    bare.word = "b"
    for name, message in ("height", "structure"), ("wort", "'word'"):
        with pytest.raises(InvalidInput, match=message):
            setattr(bare, name, 1)
    with pytest.raises(TypeError):
        Spring(3.0, worst=1.0)  # type: ignore[call-arg]
    with pytest.raises(KeyError):
        Failing()
    again = Spring(3.0)
    Spring.__init__(again, 4.0, name="other")  # as __setstate__ may
    assert (again.stiffness, again.name) == (4.0, "other")
    with pytest.raises(InvalidInput, match="structure"):
        again.name = "spring"


def test_a_declaration_replaces_that_of_the_base() -> None:
    class Stuck(Spring):
        stiffness: Array = structure()

    class Loose(Spring):
        @number
        def rows(self, value: int) -> int:
            return value

    class Borrowed(Spring):
        @property
        def least(self) -> float:
            return 1e-3

        @least.setter
        def least(self, value: float) -> None:
            pass

    with pytest.raises(InvalidInput, match="structure"):
        Stuck(np.array(3.0)).stiffness = np.ones(1)
    loose = Loose(3.0)
    loose.rows = 3
    assert loose.rows == 3
    assert "least" not in vars(Borrowed(3.0))


def test_watchers_see_all_that_a_part_holds() -> None:
    one, two, three = (Spring(k) for k in (1.0, 2.0, 3.0))
    inner = Two(three)
    whole, ledger = Two(one, one, left=two, right=inner), Ledger()  # type: ignore[arg-type]
    assert list(reachable(whole)) == [whole, one, two, inner, three]
    assert list(reachable([whole, one])) == [whole, one, two, inner, three]
    watch(whole, ledger)
    watch(whole, ledger)  # once more changes nothing
    for spring in one, two, three:
        spring.stiffness = 4.0
    assert ledger.told == [one, two, three]


def test_watchers_are_not_kept_alive() -> None:
    spring, ledger = Spring(1.0), Ledger()
    watch(spring, ledger)
    watch(spring, Ledger(0.5))
    gc.collect()
    spring.stiffness = 2.0
    assert ledger.taken == [2.0]
    watch(spring, ledger)
    assert len(spring._watchers) == 1


def test_a_watcher_may_die_or_watch_anew_while_it_is_told() -> None:
    spring, others = Spring(1.0), [Ledger(), Ledger()]

    class Restless:
        def admit(self, part: Live, name: str) -> None:
            others.clear()
            watch(part, self)

    restless = Restless()
    watch(spring, restless)
    for ledger in others:
        watch(spring, ledger)
    del ledger
    spring.stiffness = 2.0
    assert spring.stiffness == 2.0
    assert not others


class Careless(Spring):
    """Whose state is told by itself."""

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__}


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda part: pickle.loads(pickle.dumps(part))])
@pytest.mark.parametrize("kind", [Spring, Careless])
def test_copies_are_sealed_and_watched_by_nobody(kind: type[Spring], copied: Callable[[Spring], Spring]) -> None:
    spring, ledger = kind([1.0, 2.0]), Ledger()
    watch(spring, ledger)
    other = copied(spring)
    other.stiffness = 4.0
    assert spring.stiffness.tolist() == [1.0, 2.0]
    assert not ledger.told
    with pytest.raises(InvalidInput, match="stiffness"):
        other.stifness = 1.0
    with pytest.raises(InvalidInput, match="structure"):
        other.name = "b"
    spring.stiffness = 3.0
    assert ledger.told == [spring]
    assert other.stiffness == 4.0
