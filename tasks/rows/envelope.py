r"""The joint limits of one stack reconciled with each other, so that all can be kept at every tick.

Each limit alone bounds x to an interval that is never empty. Two of them may contradict each other: a joint that
comes too fast cannot keep both its range and its acceleration limit. The limits are therefore taken in an order of
hardness, whatever their levels: acceleration, position, velocity; those of one kind as they stand in
the stack. The bounds of a softer limit are widened just so far that they meet what the harder ones leave,

.. math::

    [l, u] \;\leftarrow\; [\min(l, U),\ \max(u, L)], \qquad
    [L, U] \;\leftarrow\; [L, U] \cap [l, u],

beginning with :math:`[L, U] = \pm a_{max}` at acceleration order and :math:`v \pm a_{max} dt` at velocity order.
Every intersection is nonempty, so all limits together can be kept at every tick, from any state. From a state
within the velocity limit in which the joint can still stop inside its range, nothing is widened.

*Braking.* From any motion of the joints, all of them can be slowed together, each by no more than its limit: along the
same way, in the time :math:`T = \max_j v_j / a_j`, at first at the rate 1/T. A frame whose speed towards a bound is at
most 1/T times its distance then stops before it, whichever bounds there are. v is the limit of the velocity, and where
there is none the velocity within reach.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import reduce
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hqp import InvalidInput

from ..base.checks import Array, per_row
from ..robots.robot import Quantity, Robot, limit_of

if TYPE_CHECKING:
    from ..base.loops import Call, Entry


#: What limits are of.
QUANTITIES: tuple[Quantity, ...] = ("position", "velocity", "acceleration")


class Bounded(Protocol):
    """The rows of a part, as far as joint limits need them; see :class:`tasks.rows.site.Site`."""

    lower: Array
    upper: Array


class Shared(Protocol):
    """The quantities of a tick that joint limits need; see :class:`tasks.rows.site.Workspace`."""

    robot: Robot
    n: int
    v: Array
    positions: Array
    braking: Array

    @property
    def order(self) -> str: ...

    @property
    def position_indices(self) -> NDArray[np.signedinteger]: ...


class Claim(NamedTuple):
    """The bounds that one limit puts on the joints.

    Attributes
    ----------
    kind : {"position", "velocity", "acceleration"}
    low, high : array, shape (nv,)
        Lowest and highest value [rad], [rad/s], [rad/s^2].
    lower, upper : array, shape (nv,)
        The bounds that it writes. Claims on the same bounds are kept together.
    part : str
        Full name of the limit, for messages.
    return_speed : float
        The largest speed at which a joint outside its range is driven back [rad/s].
    """

    kind: Quantity
    low: Array
    high: Array
    lower: Array
    upper: Array
    part: str
    return_speed: float

    @property
    def form(self) -> tuple[object, ...]:
        """What the loop knows of it beside its numbers."""
        return self.kind, id(self.lower), id(self.upper), self.part

    @property
    def numbers(self) -> Array:
        """Its numbers, as the loop reads them."""
        return np.concatenate([self.low, self.high, [self.return_speed]])


class Envelope:
    """The joint limits of one stack on one robot, reconciled and written by one loop.

    Where a stack has a position limit, but none of another kind, the robot's own counts for braking and for
    the way back.

    Attributes
    ----------
    velocity, acceleration : array, shape (nv,)
        The tightest limits [rad/s], [rad/s^2]; infinite where there is none.
    ends : array, shape (nv,)
        The deceleration with which a joint comes to rest at the end of its range [rad/s^2]: its acceleration limit, or
        where there is none, what :meth:`ease_ends` was told.
    has_velocity, has_acceleration : bool
        Whether the stack itself has such a limit.
    """

    def __init__(self, n: int) -> None:
        self.velocity, self.acceleration, self.ends = np.full((3, n), np.inf)
        self._gentle = np.full(n, np.inf)
        self.has_velocity = self.has_acceleration = False
        #: Writes the rows of all limits, and how fast the joints brake; every tick, before the loops that read it.
        self.calls: tuple[Call, ...] = ()
        self._claims: list[Claim] = []
        self._numbers: list[Array] = []
        self._braking = np.array([np.inf])

    def claim(self, part: str, kind: Quantity, values: Array, site: Bounded, *, return_speed: float = np.inf) -> None:
        """Ask for a limit of all joints, in the rows of a part.

        Parameters
        ----------
        part : str
            Its full name.
        kind : {"position", "velocity", "acceleration"}
        values : array, shape (2, nv)
            Lowest and highest.
        site : Site
            Where the rows are. What has several limits there keeps all of them.
        return_speed : float
            [rad/s].
        """
        self._claims.append(Claim(kind, values[0], values[1], site.lower, site.upper, part, return_speed))

    def ease_ends(self, deceleration: Array) -> None:
        """Bring joints to rest at the ends of their ranges with at most this [rad/s^2], where nothing else limits it.

        Of shape (nv,), infinite for joints that brake as they like.

        Only their speed near an end is bounded: wherever they are and however fast, they keep their ranges.
        """
        self._gentle = deceleration
        self._note_ends()

    @property
    def eased(self) -> float:
        """With what joints are braked at the ends of their ranges though nothing limits their accelerations [rad/s^2].

        Infinite if there is no such joint.
        """
        ranges = any(claim.kind == "position" for claim in self._claims)
        return float(self._gentle[np.isinf(self.acceleration)].min(initial=np.inf)) if ranges else np.inf

    def _note_ends(self) -> None:
        self.ends[:] = np.where(np.isfinite(self.acceleration), self.acceleration, self._gentle)

    def close(self, shared: Shared) -> None:
        """Have the loop ready, when all claims are there, and the rate of braking from rest.

        Raises
        ------
        InvalidInput
            If a position limit at acceleration order has nothing to brake with.
        """
        self._settle(shared)
        self._braking = shared.braking
        if self._claims:
            self.calls = (self._loop(shared),)
            self.calls[0].run()

    def _settle(self, shared: Shared, kinds: Collection[Quantity] = QUANTITIES) -> None:
        """Find the tightest limits of these kinds, and refuse positions without any to brake with."""
        if not self._claims:
            return
        self.has_velocity, self.has_acceleration = (self._has(kind) for kind in ("velocity", "acceleration"))
        if "velocity" in kinds:
            self.velocity[:] = self._tightest("velocity", shared.robot)
        if "acceleration" in kinds:
            self.acceleration[:] = self._tightest("acceleration", shared.robot)
            self._note_ends()
        ranges = [claim for claim in self._claims if claim.kind == "position"]
        if not ranges or shared.order != "acceleration":
            return
        limited = np.any([np.isfinite(claim.low) | np.isfinite(claim.high) for claim in ranges], axis=0)
        if np.isinf(self.acceleration[limited]).any():
            raise InvalidInput(
                f"{ranges[0].part}: at acceleration order it needs to know how hard the joints can"
                " brake; add a JointAccelerationLimit(20.0), in rad/s^2, to the stack, or give the robot a limit"
            )

    def renew(
        self, shared: Shared, sites: Sequence[Bounded], ask: Callable[[], None], kinds: Iterable[Quantity] = ()
    ) -> bool:
        """Take the claims that there are in the rows of some parts as they are now, where the loop has them.

        Parameters
        ----------
        shared : Workspace
        sites : sequence of Site
            Where these rows are.
        ask : callable
            Has the parts make their claims.
        kinds : iterable of str
            Those of which limits of the robot may have changed, too: one that nobody claims may stand in.

        Returns
        -------
        bool
            False if other limits are claimed than before, and the loop has to be made anew.

        Raises
        ------
        InvalidInput
            As :meth:`close` does.
        """
        before, self._claims = self._claims, list[Claim]()
        try:
            ask()
        finally:
            new, self._claims = self._claims, before
        own = [k for k, old in enumerate(before) if any(old.lower is site.lower for site in sites)]
        if [each.form for each in new] != [before[k].form for k in own]:
            return False
        changed = set(kinds)
        for k, each in zip(own, new, strict=True):
            numbers = each.numbers
            if not (numbers == self._numbers[k]).all():
                before[k], self._numbers[k][:] = each, numbers
                changed.add(each.kind)
        self._settle(shared, changed)
        shared.v[:] = 0.0
        self.calls[0].run()
        return True

    def loops(self, site: Bounded) -> tuple[str, ...]:
        """The name of the loop that writes the rows of a part, if there are limits in them."""
        own = any(claim.lower is site.lower for claim in self._claims)
        return tuple(call.kernel.__name__ for call in self.calls) if own else ()

    @property
    def brakes_blindly(self) -> bool:
        """Whether some acceleration is limited, but not the velocity of that joint."""
        return bool((np.isfinite(self.acceleration) & np.isinf(self.velocity)).any())

    def braking_rate(self) -> float:
        """The largest rate [1/s] at which a frame may near a bound in this tick, if the joints are to stop in time.

        It is infinite where nothing limits the acceleration.
        """
        return float(self._braking[0])

    def _has(self, kind: Quantity) -> bool:
        return any(claim.kind == kind for claim in self._claims)

    def _tightest(self, kind: Quantity, robot: Robot) -> Array:
        """The smallest limit of this kind in every joint; the robot's own if there is none and it may stand in."""
        limits = [claim.high for claim in self._claims if claim.kind == kind]
        own = limit_of(robot, kind)
        if not limits and self._has("position") and own is not None:
            limits = [per_row(own, robot.nv, f"{robot!r}: {kind} limit", "joint")]
        return reduce(np.minimum, limits, np.array(np.inf))

    def _loop(self, shared: Shared) -> Call:
        """The loop with all claims as arguments, the harder ones first."""
        from ..base.loops import Call, Table, address
        from .kernels import envelope as loop
        from .kernels.law import ORDERS

        self._numbers = [claim.numbers for claim in self._claims]
        pairs = zip(self._claims, self._numbers, strict=True)
        claims = sorted(pairs, key=lambda pair: loop.KINDS.index(pair[0].kind))
        told_of: list[tuple[Entry, ...]] = [
            (loop.KINDS.index(claim.kind), numbers, claim.lower, claim.upper) for claim, numbers in claims
        ]
        rows = {address(claim.lower): (claim.lower, claim.upper) for claim, _ in claims}.values()
        told: dict[int, Entry] = {
            loop.ORDER: ORDERS.index(shared.order),
            loop.N: shared.n,
            loop.V: shared.v,
            loop.POSITIONS: shared.positions,
            loop.NQ: len(shared.positions),
            loop.PLACES: np.ascontiguousarray(shared.position_indices, dtype=np.int64),
            loop.TICK: shared.braking,
            loop.VELOCITY: self.velocity,
            loop.ACCELERATION: self.acceleration,
            loop.ENDS: self.ends,
            loop.LEFT: np.empty(2 * shared.n),
            loop.ROWS: Table(*chain.from_iterable(rows)),
            loop.ROWS_COUNT: len(rows),
            loop.CLAIMS: Table(*chain.from_iterable(told_of)),
            loop.CLAIMS_COUNT: len(claims),
        }
        return Call(loop.write_joint_limits, *(told[k] for k in range(loop.LENGTH)))
