r"""Joints that a file ties to others: :math:`q = m\, q_{leader} + o`, where the leader may follow another one in turn.

Both move together, so each has to stay in the range of the other as well: the range of the leader is narrowed to what
all its followers allow, and its speed to what theirs do. A leader that is fixed has the position 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from .._checks import Array
from .choices import Mimic
from .ranges import known
from .reduction import SAME, carried, reduced


@dataclass(frozen=True)
class Tie:
    """A joint that follows another one: its position is ``factor`` times that of the leader plus ``offset``.

    Without a leader it is the offset.
    """

    follower: str
    leader: str | None
    factor: float
    offset: float


def resolve(ties: Iterable[Tie], model: pin.Model, fixed: Iterable[str], held: Iterable[str], what: str) -> list[Tie]:
    """The ties of joints that the model has, each to a joint that follows no other.

    Parameters
    ----------
    ties : iterable of Tie
    model : pinocchio.Model
    fixed : names
        Joints of the file that are none of the model, as they do not move.
    held : names
        Joints that are held, and may do without their leader.
    what : str
        The file, for messages.

    Raises
    ------
    InvalidInput
        If a leader is missing, has more than one number, or follows itself.
    """
    own, still = dict[str, Tie](), set(fixed)
    for tie in ties:
        if tie.follower in own:
            raise InvalidInput(f"{what}: joint {tie.follower!r} follows two others; it must follow one")
        own[tie.follower] = tie
    known = still | set(model.names)
    own = {name: tie for name, tie in own.items() if name not in held or tie.leader is None or tie.leader in known}
    return [_resolved(tie, own, model, still, what) for name, tie in own.items() if name not in still]


def _resolved(tie: Tie, ties: Mapping[str, Tie], model: pin.Model, fixed: set[str], what: str) -> Tie:
    seen = [tie.follower]
    while tie.leader is not None:
        if tie.leader in fixed:
            return replace(tie, leader=None)
        for name in tie.follower, tie.leader:
            if not model.existJointName(name):
                raise InvalidInput(
                    f"{what}: joint {tie.follower!r} follows {tie.leader!r}, and {name!r} is no joint of the file;"
                    f" mimic='free' lets all joints move on their own, lock={{{tie.follower!r}: ...}} holds this one"
                )
            if model.joints[model.getJointId(name)].nq != 1:
                raise InvalidInput(f"{what}: {tie.follower!r} follows {tie.leader!r}; {name!r} must have one position")
        if tie.factor == 0.0:
            return replace(tie, leader=None)
        above = ties.get(tie.leader)
        if above is None:
            return tie
        if above.follower in seen:
            raise InvalidInput(f"{what}: joint {tie.follower!r} follows itself, by {' and '.join(map(repr, seen))}")
        seen.append(above.follower)
        tie = Tie(tie.follower, above.leader, tie.factor * above.factor, tie.factor * above.offset + tie.offset)
    return tie


def arrange(
    model: pin.Model, neutral: Array, ties: list[Tie], mimic: Mimic, lock: Mapping[str, float | None], what: str
) -> tuple[pin.Model, Array]:
    """The model with its ties as asked for, and with these joints held; and the neutral configuration of it.

    Parameters
    ----------
    model : pinocchio.Model
        Every joint of it on its own.
    neutral : array, shape (nq,)
    ties : list of Tie
        Resolved.
    mimic : {"lock", "follow"}
    lock : dict of name to float or None
        Where to hold joints; None for neutral.
    what : str

    Raises
    ------
    InvalidInput
        If the joints of a tie are left no range, or held where they cannot both be, or lock names no joint or a
        position outside its range.
    """
    model, neutral, held = pin.Model(model), np.array(neutral), dict(lock)
    free = [tie for tie in ties if mimic == "follow" or tie.follower not in held]
    groups: dict[str, list[Tie]] = {}
    for tie in free:
        if tie.leader is None:
            held.setdefault(tie.follower, tie.offset)
        else:
            groups.setdefault(tie.leader, []).append(tie)
    for leader, own in groups.items():
        _narrow(model, leader, own, what)
        place = _place(model, leader)
        low, high = model.lowerPositionLimit[place], model.upperPositionLimit[place]
        neutral[place] = np.clip(neutral[place], low, high)
        _hold_together(held, leader, own, float(neutral[place]), mimic, what)
        for tie in own:
            neutral[_place(model, tie.follower)] = tie.factor * neutral[place] + tie.offset
    model, neutral = reduced(model, held, neutral, what)
    for leader, own in groups.items():
        model, neutral = _followed(model, neutral, leader, [tie for tie in own if tie.follower not in held])
    return model, neutral


def _place(model: pin.Model, joint: str) -> int:
    return int(model.joints[model.getJointId(joint)].idx_q)


def _narrow(model: pin.Model, leader: str, ties: list[Tie], what: str) -> None:
    """Narrow range and speed of the leader to what all its followers allow."""
    place, column = _place(model, leader), int(model.joints[model.getJointId(leader)].idx_v)
    low, high = model.lowerPositionLimit[place], model.upperPositionLimit[place]
    speeds = known(model.velocityLimit)
    for tie in ties:
        own = _place(model, tie.follower)
        least, most = model.lowerPositionLimit[own], model.upperPositionLimit[own]
        ends = sorted(((least - tie.offset) / tie.factor, (most - tie.offset) / tie.factor))
        low, high = max(low, ends[0]), min(high, ends[1])
        if low > high:
            raise InvalidInput(
                f"{what}: joint {tie.follower!r} follows {leader!r}, and the ranges of both leave it no position"
            )
        follower = model.joints[model.getJointId(tie.follower)].idx_v
        speeds[column] = min(speeds[column], speeds[follower] / abs(tie.factor))
    model.lowerPositionLimit[place], model.upperPositionLimit[place] = low, high
    model.velocityLimit[column] = speeds[column]


def _hold_together(
    held: dict[str, float | None], leader: str, ties: list[Tie], neutral: float, mimic: Mimic, what: str
) -> None:
    """Hold the followers where the leader puts them; all joints of a tie, if they are to follow and one is held."""
    asked = [tie for tie in ties if tie.follower in held]
    if mimic == "follow" and leader not in held and asked:
        position = held[asked[0].follower]
        held[leader] = neutral if position is None else (position - asked[0].offset) / asked[0].factor
    if mimic == "follow" and leader not in held:
        return
    at = held.get(leader)
    at = neutral if at is None else at
    for tie in ties:
        position, own = held.get(tie.follower), tie.factor * at + tie.offset
        if position is not None and abs(position - own) > SAME:
            raise InvalidInput(
                f"{what}: lock holds {tie.follower!r} at {position:g}; as it follows {leader!r}, it must be {own:g}"
            )
        held[tie.follower] = own


def _followed(model: pin.Model, neutral: Array, leader: str, ties: list[Tie]) -> tuple[pin.Model, Array]:
    """Tie joints together. The one that comes first in the tree is the independent one, as Pinocchio demands."""
    if not ties:
        return model, neutral
    all_of = [Tie(leader, leader, 1.0, 0.0), *ties]
    driver = min(all_of, key=lambda tie: model.getJointId(tie.follower))
    low, high = (model.lowerPositionLimit[_place(model, leader)], model.upperPositionLimit[_place(model, leader)])
    speed = model.velocityLimit[model.joints[model.getJointId(leader)].idx_v]
    for tie in all_of:
        if tie is driver:
            continue
        factor = tie.factor / driver.factor
        before = model
        led, own = (before.joints[before.getJointId(t.follower)].idx_v for t in (driver, tie))
        resists = [
            before.armature[led] + factor**2 * before.armature[own],
            before.damping[led] + factor**2 * before.damping[own],
            before.friction[led] + abs(factor) * before.friction[own],
        ]
        model = pin.transformJointIntoMimic(
            before,
            before.getJointId(driver.follower),
            before.getJointId(tie.follower),
            factor,
            tie.offset - factor * driver.offset,
        )
        led = model.joints[model.getJointId(driver.follower)].idx_v
        model.armature[led], model.damping[led], model.friction[led] = resists
        neutral = carried(neutral, before, model)
        for name, q in [(entry.key(), np.array(entry.data())) for entry in before.referenceConfigurations]:
            model.referenceConfigurations[name] = carried(q, before, model)
    place = _place(model, driver.follower)
    ends = sorted((driver.factor * low + driver.offset, driver.factor * high + driver.offset))
    model.lowerPositionLimit[place], model.upperPositionLimit[place] = ends
    model.velocityLimit[model.joints[model.getJointId(driver.follower)].idx_v] = abs(driver.factor) * speed
    return model, neutral
