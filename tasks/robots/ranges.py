"""Joint limits of a Pinocchio robot: those of the model, and those given for all or some joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from hqp import InvalidInput

from ..base.checks import LARGEST, Array, not_negative, per_joint, position_range, positive, scalar
from ..base.telling import tell
from .follower_limits import FollowerLimits
from .joint_axes import NONE, JointAxis, further_bases, joint_axes, kind
from .refusals import joint_index

#: Limit stored in a model for a joint that is held, or has no motor: 0 would mean that the limit is unknown.
HELD = 1e-300
#: Two joint positions this close are equal [rad], [m].
SAME = 1e-9


def unknown_ranges(model: pin.Model, what: str) -> list[JointAxis]:
    """The joints with a range from 0 to 0, which means unknown in model files; logged once."""
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    found = [
        axis for axis in joint_axes(model) if axis.q_index != NONE and low[axis.q_index] == high[axis.q_index] == 0.0
    ]
    if found:
        names = ", ".join(axis.name for axis in found)
        tell(f"{what}: joints whose range is from 0 to 0 are taken to have none: {names}")
    return found


def open_ranges(model: pin.Model, what: str) -> None:
    """Make ranges that are unknown, or larger than any robot, infinite in the model."""
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    for axis in unknown_ranges(model, what):
        low[axis.q_index], high[axis.q_index] = -np.inf, np.inf
    low[low < -LARGEST], high[high > LARGEST] = -np.inf, np.inf


def known(limits: Array) -> Array:
    """Largest speeds or torques, shape (nv,); infinite where a model has 0, which means unknown."""
    own = np.array(limits)
    own[(own == 0.0) | (own > LARGEST)] = np.inf
    return own


def both_ways(lower: Array, upper: Array, names: Sequence[str], what: str) -> Array:
    """Largest speeds or torques, shape (nv,): the upper limits, which most programs set alone; others are told.

    Parameters
    ----------
    lower, upper : array, shape (nv,)
        Of the model.
    names : sequence of str
        Of the axes.
    what : str
        The robot and the quantity, for messages.
    """
    limits = known(upper)
    other = known(np.where(lower < 0.0, -lower, np.inf))
    told = [name for name, low, high in zip(names, other, limits, strict=True) if low < high]
    if told:
        tell(f"{what}: the upper limit counts for both directions, where the lower one is smaller: {', '.join(told)}")
    return limits


def without_motors(model: pin.Model, limits: Array | None, what: str) -> Array:
    """Largest torques, 0 for bodies that are free besides the base, unless the model has numbers; this is told once."""
    own = np.full(model.nv, np.inf) if limits is None else limits
    names, free = further_bases(model)
    unknown = [i for i in free if known(model.upperEffortLimit)[i] == np.inf]
    if unknown:
        own[unknown] = 0.0
        tell(f"{what}: it is 0 of joints that float, or stand in the plane, besides the base: {', '.join(names)}")
    return own


def position_limit(model: pin.Model, given: Any, what: str, *, zero_is_none: bool = True) -> Array | None:
    """Lowest and highest positions, shape (2, nv): the model's, replaced by those given.

    Parameters
    ----------
    model : pinocchio.Model
    given : pair of float or array, dict of name to pair, or None
        For all joints that have a position, or for those in the dict.
    what : str
        The robot, for messages.
    zero_is_none : bool
        Whether a range from 0 to 0 in the model means unknown.

    Returns
    -------
    array, shape (2, nv), or None
        Infinite for a joint without limit; None if no joint has one.

    Raises
    ------
    InvalidInput
        If a joint is unknown, has no position of its own, or its lowest is above its highest.
    """
    own = joint_axes(model)
    has = np.array([axis.q_index != NONE for axis in own])
    if given is None or isinstance(given, Mapping):
        limits = _of_model(model, own, what, zero_is_none)
        for i, pair in _named(own, given or {}, f"{what}: position limit of"):
            label = f"{what}: position limit of {own[i].name!r}"
            if not has[i]:
                raise InvalidInput(f"{label} = {pair}: {no_position(own[i])}; it must have none")
            limits[:, i] = position_range(pair, 1, label, has[i : i + 1], [own[i].unit], [own[i].name])[:, 0]
    else:
        units, names = [axis.unit for axis in own], [axis.name for axis in own]
        limits = position_range(given, len(own), f"{what}: position limit", has, units, names)
    return limits if np.isfinite(limits).any() else None


def no_position(axis: JointAxis) -> str:
    """Why this axis has no position of its own."""
    if axis.circle != NONE and axis.name == axis.joint:
        return "it turns without end, and has an angle on a circle"
    return "it is one of several of a base, a ball or a plane, and has no position of its own"


def _of_model(model: pin.Model, own: Sequence[JointAxis], what: str, zero_is_none: bool) -> Array:
    _tell_of_bases(model, what)
    limits = np.array([[-np.inf], [np.inf]]).repeat(len(own), axis=1)
    unknown = {axis.q_index for axis in unknown_ranges(model, what)} if zero_is_none else set()
    for i, axis in enumerate(own):
        if axis.q_index != NONE and axis.q_index not in unknown:
            low, high = model.lowerPositionLimit[axis.q_index], model.upperPositionLimit[axis.q_index]
            limits[:, i] = low if low > -LARGEST else -np.inf, high if high < LARGEST else np.inf
    return limits


def _tell_of_bases(model: pin.Model, what: str) -> None:
    """Warn of joints with position limits in the model that cannot be used, as they have no single position."""
    told = []
    for joint, name in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):
        places = slice(joint.idx_q, joint.idx_q + {"Planar": 2, "FreeFlyer": 3}.get(kind(joint), 0))
        ends = np.concatenate([model.lowerPositionLimit[places], model.upperPositionLimit[places]])
        if (np.abs(ends) < LARGEST).any() and ends.any():
            told.append(name)
    if told:
        tell(f"{what}: the places of bases are not limited, whatever the model says: {', '.join(told)}")


def largest(
    model: pin.Model, given: Any, own: Array | None, what: str, units: Mapping[str, str], *, zero_holds: bool = False
) -> Array | None:
    """Largest speeds, accelerations or torques, shape (nv,): the model's, replaced by those given.

    Parameters
    ----------
    model : pinocchio.Model
    given : float, array, dict of name to float, or None
    own : array, shape (nv,), or None
        The limits in the model.
    what : str
        The robot and the quantity, for messages.
    units : dict
        The unit of the quantity for a joint that turns ("rad") and for one that slides ("m").
    zero_holds : bool
        Whether 0 is allowed, which holds a joint.

    Returns
    -------
    array, shape (nv,), or None
        Infinite for a joint without limit; None if no joint has one.

    Raises
    ------
    InvalidInput
        If a joint is unknown, or a limit is not positive.
    """
    if given is None or isinstance(given, Mapping):
        all_of, checked = joint_axes(model), not_negative if zero_holds else positive
        limits = np.full(len(all_of), np.inf) if own is None else np.array(own)
        for i, value in _named(all_of, given or {}, f"{what} of"):
            limits[i] = scalar(checked(value, f"{what} of {all_of[i].name!r}", unit=units[all_of[i].unit]), what)
        return limits if np.isfinite(limits).any() else None
    limits = per_joint(given, model.nv, what, unit=units["rad"], zero_holds=zero_holds)
    return limits if np.isfinite(limits).any() else None


def _named(own: Sequence[JointAxis], given: Mapping[str, Any], what: str) -> Iterator[tuple[int, Any]]:
    """Of each value given for a joint, the axes that it is for: all of a joint with several, as of a ball."""
    names = [axis.name for axis in own]
    for name, value in given.items():
        several = [i for i, axis in enumerate(own) if axis.joint == name != axis.name]
        for i in several or [joint_index(names, name, f"{what} joint")]:
            yield i, value


def within(
    limits: Array | None, names: Sequence[str], follower_limits: Mapping[str, FollowerLimits], what: str, *, told: bool
) -> Array | None:
    """Lowest and highest position of every joint, narrowed to what its followers allow.

    Parameters
    ----------
    limits : array, shape (2, nv), or None
    names : sequence of str
    follower_limits : dict of str to FollowerLimits
    what : str
    told : bool
        Whether the user gave the limits; narrowing them is then logged.

    Raises
    ------
    InvalidInput
        If a joint has no range left.
    """
    if limits is None:
        if not follower_limits:
            return None
        limits = np.array([[-np.inf], [np.inf]]).repeat(len(names), axis=1)
    for joint, theirs in follower_limits.items():
        column = list(names).index(joint)
        asked = limits[:, column].tolist()
        low, high = max(asked[0], theirs.low), min(asked[1], theirs.high)
        if told and [low, high] != asked and np.isfinite(asked).all():
            tell(f"{what}: position limit of {joint!r} is {low:g} .. {high:g}: those that are tied to it allow no more")
        if low > high:
            raise InvalidInput(
                f"{what}: position limit of {joint!r} from {limits[0, column]:g} to {limits[1, column]:g}; those that"
                f" follow it need {theirs.low:g} to {theirs.high:g}"
            )
        limits[:, column] = low + 0.0, high + 0.0  # turns -0 into 0
    return limits


def held_at_zero(limits: Array | None) -> Array | None:
    """Limits with the 0 that a model cannot hold, where it means unknown."""
    if limits is not None:
        limits[limits <= HELD] = 0.0
    return limits


def no_faster(
    limits: Array | None, names: Sequence[str], follower_limits: Mapping[str, FollowerLimits]
) -> Array | None:
    """Largest speeds, reduced to what the followers of each joint allow; 0 for a joint that is held."""
    limits = held_at_zero(limits)
    if limits is not None:
        for joint, theirs in follower_limits.items():
            column = list(names).index(joint)
            limits[column] = min(limits[column], theirs.speed)
    return limits
