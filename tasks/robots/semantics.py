"""Named configurations and groups of joints of a robot: keyframes, and the names of an SRDF."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Self

import numpy as np
import pinocchio as pin

from hqp import InvalidInput
from hqp.errors import brief

from ..base.checks import Array, suggestion
from ..base.telling import tell
from .joint_axes import NONE, JointAxis


class Groups(dict[str, tuple[str, ...]]):
    """Joints by group; a name that is none is refused with those that there are."""

    def __missing__(self, name: object) -> tuple[str, ...]:
        raise InvalidInput(f"{name!r} is no group of the robot{suggestion(str(name), self)}")


class Semantic:
    """A base of :class:`tasks.PinocchioRobot`."""

    model: pin.Model
    _axes: tuple[JointAxis, ...]
    #: Joints by group, and positions by configuration and joint.
    _groups: Mapping[str, tuple[str, ...]] = MappingProxyType({})
    _states: Mapping[str, Mapping[str, Array]] = MappingProxyType({})

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """Groups of joints of an SRDF, see :meth:`with_srdf`; use them where tasks take names of joints."""
        return Groups(self._groups)

    @property
    def configurations(self) -> tuple[str, ...]:
        """The names of its configurations: keyframes of an MJCF, group states of an SRDF."""
        keyframes = (str(entry.key()) for entry in self.model.referenceConfigurations)
        return tuple(dict.fromkeys((*keyframes, *self._states)))

    def with_srdf(self, file: str | PathLike[str]) -> Self:
        """The same robot with the groups and the group states of an SRDF.

        ``robot.configuration("ready")`` is then a group state, with all other joints neutral, and
        ``robot.groups["arm"]`` are the joints of a group, as for ``Freeze(all_but=robot.groups["arm"])``. Locked joints
        are left out. Names in the file that the robot does not have, and positions outside the range of a joint, are
        logged. If two groups have states of the same name that contradict each other, each is named
        ``"group/name"``. A state replaces a keyframe of the same name; home is unchanged.

        Parameters
        ----------
        file : str or path

        Raises
        ------
        InvalidInput
            If the file cannot be read, has no group and no group state, names nothing that the robot has, or gives a
            joint a wrong number of values, or two positions.
        """
        from .files.srdf import read_srdf

        if not isinstance(file, str | PathLike):
            raise InvalidInput(f"with_srdf: file = {brief(file)} is a {type(file).__name__}; it must be a path")
        path = Path(file)
        what = f"{self!r}: with_srdf: {brief(str(path))}"
        read, other = read_srdf(path, self.model, what), copy(self)
        if read.unknown:
            tell(f"{what}: names what the robot has not: {', '.join(read.unknown)}")
        empty = [name for name, joints in read.groups.items() if not joints]
        if empty:
            tell(f"{what}: groups without a joint that moves: {', '.join(empty)}")
        other._groups = {
            name: tuple(axis.name for axis in self._axes if axis.joint in joints)
            for name, joints in read.groups.items()
        }
        other._states = read.states
        for name, positions in read.states.items():
            told = f"{what}: configuration {name!r}"
            wanted, moved = other._put(pin.neutral(self.model), positions, told), other.configuration(name)
            outside = [
                axis.name
                for axis in self._axes
                if axis.joint in positions and axis.q_index != NONE and wanted[axis.q_index] != moved[axis.q_index]
            ]
            if outside:
                tell(f"{told} is outside the range of {', '.join(outside)} [rad], [m]; it is moved into it")
        return other

    def configuration(self, joints: str | Mapping[str, float]) -> Array:
        """See :meth:`tasks.PinocchioRobot.configuration`."""
        raise NotImplementedError

    def _put(self, q: Array, positions: Mapping[str, Array], what: str) -> Array:
        """q with these joints at these positions; names that are not joints of the model are ignored."""
        q = np.array(q)
        for name, numbers in positions.items():
            if not self.model.existJointName(name):
                continue
            joint = self.model.joints[self.model.getJointId(name)]
            own = [axis for axis in self._axes if axis.joint == name]
            if len(own) == 1 and own[0].circle != NONE and len(numbers) == 1:
                q[own[0].circle : own[0].circle + 2] = np.cos(numbers[0]), np.sin(numbers[0])
            elif own and len(numbers) == joint.nq:
                q[joint.idx_q : joint.idx_q + joint.nq] = numbers
            elif own:
                raise InvalidInput(f"{what}: joint {name!r} has {len(numbers)} numbers; it must have {joint.nq}")
        pin.normalize(self.model, q)
        return q
