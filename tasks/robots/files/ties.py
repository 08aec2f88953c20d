r"""Mimic joints: :math:`q = m\, q_{leader} + o`, where the leader may follow another joint in turn.

Both joints move together, so each must also stay in the range of the other: the range and the speed of the leader are
narrowed to what all its followers allow. A leader that is a fixed joint has the position 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ...base.checks import Array
from ...base.telling import tell
from ..choices import Mimic
from ..follower_limits import FollowerLimits
from ..keeping import Recipe
from ..ranges import SAME, known
from .reduction import carried, reduced

#: Tolerance for mimic joints in the named configurations of a file [rad], [m].
KEYED = 1e-6


@dataclass(frozen=True)
class Tie:
    """A joint that follows another one: its position is ``factor`` times that of the leader plus ``offset``.

    Without a leader its position is the offset.
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
        Fixed joints of the file, which are not in the model.
    held : names
        Locked joints; their leader may be missing.
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


class Arrangement(NamedTuple):
    """A model with joints tied and held.

    Attributes
    ----------
    model : pinocchio.Model
    neutral : array, shape (nq,)
    follower_limits : dict of str to FollowerLimits
        The range and speed that the followers of each joint allow it.
    recipe : Recipe or None
        How its ties were made, if it has some.
    """

    model: pin.Model
    neutral: Array
    follower_limits: dict[str, FollowerLimits]
    recipe: Recipe | None


def arrange(
    model: pin.Model, neutral: Array, ties: list[Tie], mimic: Mimic, lock: Mapping[str, float | None], what: str
) -> Arrangement:
    """The model with its ties as asked for, and with these joints held.

    Parameters
    ----------
    model : pinocchio.Model
        The model in which every joint is independent.
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
        If the joints of a tie have no common range, or are locked at positions that contradict the tie, or `lock` has
        an unknown joint or a position outside its range.
    """
    model, neutral, held = pin.Model(model), np.array(neutral), dict(lock)
    groups = _groups(ties, mimic, held, what)
    follower_limits: dict[str, FollowerLimits] = {}
    for leader, own in groups.items():
        index = _q_index(model, leader)
        driver = _driver(model, leader, own) if mimic == "follow" else _itself(leader)
        follower_limits[driver.follower] = _left_by_followers(model, driver, [_itself(leader), *own])
        _narrow(model, leader, own, what)
        neutral[index] = np.clip(neutral[index], model.lowerPositionLimit[index], model.upperPositionLimit[index])
        _hold_together(held, leader, own, float(neutral[index]), mimic, what)
        _tell_of_configurations(model, leader, own, what)
        for tie in own:
            neutral[_q_index(model, tie.follower)] = tie.factor * neutral[index] + tie.offset
    model, neutral = reduced(model, held, neutral, what)
    untied, made = model, list[tuple[str, str, float, float]]()
    for leader, own in groups.items():
        if mimic == "follow" and leader not in held:
            model, neutral = _followed(model, neutral, leader, own, made)
    follower_limits = {joint: theirs for joint, theirs in follower_limits.items() if joint not in held}
    return Arrangement(model, neutral, follower_limits, Recipe(untied, tuple(made)) if made else None)


def _itself(leader: str) -> Tie:
    """A leader as a tie to itself."""
    return Tie(leader, leader, 1.0, 0.0)


def _driver(model: pin.Model, leader: str, ties: list[Tie]) -> Tie:
    """The independent joint among joints tied together: the first in the tree, as Pinocchio demands."""
    return min([_itself(leader), *ties], key=lambda tie: model.getJointId(tie.follower))


def _groups(ties: list[Tie], mimic: Mimic, held: dict[str, float | None], what: str) -> dict[str, list[Tie]]:
    """The ties of each leader; joints without a leader are locked in place, and added to `held`.

    With mimic "lock", a follower that the user locks at a position is no longer tied.
    """
    groups: dict[str, list[Tie]] = {}
    for tie in ties:
        asked = held.get(tie.follower)
        if tie.leader is None:
            if asked is not None and abs(asked - tie.offset) > SAME:
                raise InvalidInput(f"{what}: lock holds {tie.follower!r} at {asked:g}; it must be {tie.offset:g}")
            held[tie.follower] = tie.offset
        elif mimic == "follow" or asked is None:
            groups.setdefault(tie.leader, []).append(tie)
    return groups


def _q_index(model: pin.Model, joint: str) -> int:
    return int(model.joints[model.getJointId(joint)].idx_q)


def _column(model: pin.Model, joint: str) -> int:
    return int(model.joints[model.getJointId(joint)].idx_v)


def _left_by_followers(model: pin.Model, driver: Tie, ties: list[Tie]) -> FollowerLimits:
    """The range and speed of a joint that its followers allow."""
    low, high, speed = -np.inf, np.inf, np.inf
    speeds = known(model.upperVelocityLimit)
    for tie in ties:
        if tie.follower != driver.follower:
            factor = tie.factor / driver.factor
            offset, own = tie.offset - factor * driver.offset, _q_index(model, tie.follower)
            least, most = model.lowerPositionLimit[own], model.upperPositionLimit[own]
            ends = sorted(((least - offset) / factor, (most - offset) / factor))
            low, high = max(low, ends[0]), min(high, ends[1])
            speed = min(speed, speeds[_column(model, tie.follower)] / abs(factor))
    return FollowerLimits(float(low), float(high), float(speed))


def _narrow(model: pin.Model, leader: str, ties: list[Tie], what: str) -> None:
    """Narrow the range and speed of the leader to what its followers allow."""
    theirs = _left_by_followers(model, _itself(leader), ties)
    index, column = _q_index(model, leader), _column(model, leader)
    low, high = max(model.lowerPositionLimit[index], theirs.low), min(model.upperPositionLimit[index], theirs.high)
    followers = " and ".join(repr(tie.follower) for tie in ties)
    if low > high:
        raise InvalidInput(f"{what}: joint {followers} follows {leader!r}, and the ranges of both leave it no position")
    if high - low <= SAME:
        tell(f"{what}: joint {leader!r} cannot move: its range and that of {followers} leave it {low:g} alone")
    model.lowerPositionLimit[index], model.upperPositionLimit[index] = low, high
    _limit_speed(model, column, min(known(model.upperVelocityLimit)[column], theirs.speed))


def _tell_of_configurations(model: pin.Model, leader: str, ties: list[Tie], what: str) -> None:
    """Warn of named configurations in which a follower is not where its leader puts it."""
    for entry in model.referenceConfigurations:
        q = np.array(entry.data())
        for tie in ties:
            own = tie.factor * q[_q_index(model, leader)] + tie.offset
            if abs(q[_q_index(model, tie.follower)] - own) > KEYED:
                tell(f"{what}: configuration {entry.key()!r} has {tie.follower!r} where {leader!r} does not put it")


def _limit_speed(model: pin.Model, column: int, speed: float) -> None:
    model.upperVelocityLimit[column], model.lowerVelocityLimit[column] = speed, -speed


def _hold_together(
    held: dict[str, float | None], leader: str, ties: list[Tie], neutral: float, mimic: Mimic, what: str
) -> None:
    """Lock the followers where the leader puts them, or, with "follow", all joints of a tie if one is locked."""
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


def _followed(
    model: pin.Model, neutral: Array, leader: str, ties: list[Tie], made: list[tuple[str, str, float, float]]
) -> tuple[pin.Model, Array]:
    """Tie joints together, and append the ties to `made`; returns the model and its neutral configuration."""
    all_of, driver = [_itself(leader), *ties], _driver(model, leader, ties)
    index, column = _q_index(model, leader), _column(model, leader)
    whole = FollowerLimits(
        model.lowerPositionLimit[index], model.upperPositionLimit[index], model.upperVelocityLimit[column]
    ).seen_through(driver.factor, driver.offset)
    torque = known(model.upperEffortLimit)[column] / abs(driver.factor)  # the motor drives the leader
    resists = np.zeros(3)
    for tie in all_of:
        factor, own = tie.factor / driver.factor, _column(model, tie.follower)
        resists += factor**2 * model.armature[own], factor**2 * model.damping[own], abs(factor) * model.friction[own]
    for tie in all_of:
        if tie.follower != driver.follower:
            factor = tie.factor / driver.factor
            made.append((driver.follower, tie.follower, factor, tie.offset - factor * driver.offset))
            model, neutral = _mimicking(model, neutral, *made[-1])
    index, column = _q_index(model, driver.follower), _column(model, driver.follower)
    model.lowerPositionLimit[index], model.upperPositionLimit[index] = whole.low, whole.high
    _limit_speed(model, column, whole.speed)
    model.upperEffortLimit[column], model.lowerEffortLimit[column] = torque, -torque
    model.armature[column], model.damping[column], model.friction[column] = resists
    return model, neutral


def _mimicking(
    model: pin.Model, neutral: Array, leader: str, follower: str, factor: float, offset: float
) -> tuple[pin.Model, Array]:
    """The model in which one joint follows another, and its neutral configuration."""
    tied = pin.transformJointIntoMimic(model, model.getJointId(leader), model.getJointId(follower), factor, offset)
    for entry in model.referenceConfigurations:
        tied.referenceConfigurations[entry.key()] = carried(np.array(entry.data()), model, tied)
    return tied, carried(neutral, model, tied)
