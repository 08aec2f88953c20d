"""Data of a contact: the place where a frame touches the world, the friction, and the unknown forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type, truth, whole_number

from ..base.checks import Array, finite, not_negative, positive_scalar, scalar
from ..base.live import number, structure
from ..rows.part import Part
from ..rows.unknowns import Block
from .shape import Shape, shape_of
from .slot import Slot
from .surface import Surface

if TYPE_CHECKING:
    from ..rows.site import Workspace

#: Default gain with which a contact returns to its place after it has moved [1/s].
GAIN = 20.0
AXES = ("t1", "t2", "normal")


class ContactModel(Part):
    """The data of a contact, without its rows; see :class:`tasks.Contact`."""

    frame: str = structure()
    shape: Shape = structure()
    surface: Surface | None = structure()
    unilateral: bool = structure()
    faces: int = structure()
    wrench: bool = structure()
    may_slip: bool = structure()
    radius: float | None = structure()

    def __init__(
        self,
        frame: str,
        *,
        points: ArrayLike | None = None,
        plane: ArrayLike | None = None,
        line: float | None = None,
        radius: float | None = None,
        centre: ArrayLike = (0.0, 0.0, 0.0),
        friction: float | None = None,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        surface: Surface | None = None,
        name: str | None = None,
        unilateral: bool = True,
        faces: int = 4,
        wrench: bool = False,
        torsion: float | None = None,
        least: float = 0.0,
        largest: float = np.inf,
        gain: float = GAIN,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        may_slip: bool = False,
    ) -> None:
        self.frame = of_type(frame, str, "frame of a Contact")
        self.name = frame if name is None else of_type(name, str, "name of a Contact")
        self.shape = shape_of(points, plane, line, centre, self.full_name())
        self._lengths = None if plane is None else finite(plane, "plane")
        self.unilateral, self.may_slip = truth(unilateral, "unilateral"), truth(may_slip, "may_slip")
        self.faces = whole_number(faces, f"{self.full_name()}: faces", least=3)
        self.surface = None if surface is None else of_type(surface, Surface, f"{self.full_name()}: surface")
        self.wrench = truth(wrench, "wrench")
        if self.wrench and plane is None:
            raise InvalidInput(f"{self.full_name()}: wrench = True takes a plane=(length along x, length along y) in m")
        self.radius = None if radius is None else positive_scalar(radius, f"{self.full_name()}: radius", unit="m")
        if self.radius is not None and (surface, points, plane, line) != (None, None, None, None):
            raise InvalidInput(
                f"{self.full_name()}: what rolls, radius = {self.radius:g} m, touches the world at one point; it takes"
                " no points, plane, line or surface"
            )
        self.friction, self.normal, self.torsion = friction, normal, torsion
        self.least, self.largest = least, largest
        self.gain, self.damping_ratio, self.weight = gain, damping_ratio, weight
        self._renew()

    @number
    def friction(self, value: float | None) -> float | None:
        """The coefficient of friction mu."""
        return None if value is None else positive_scalar(value, f"{self.full_name()}: friction")

    @number
    def torsion(self, value: float | None) -> float | None:
        """Largest moment about the normal, divided by the normal force [m]."""
        return None if value is None else positive_scalar(value, f"{self.full_name()}: torsion", unit="m")

    @number
    def normal(self, value: ArrayLike) -> Array:
        """Unit vector in which the surface pushes on the robot, shape (3,)."""
        n = finite(value, f"{self.full_name()}: normal")
        norm = float(np.linalg.norm(n))
        if n.shape != (3,) or not 0.0 < norm < np.inf:
            raise InvalidInput(f"{self.full_name()}: normal = {n.tolist()} must be a direction, shape (3,)")
        return np.asarray(n / norm)

    @number
    def least(self, value: float) -> float:
        """Least sum of the normal forces [N]."""
        return scalar(not_negative(value, f"{self.full_name()}: least", unit="N"), "least")

    @number
    def largest(self, value: float) -> float:
        """Largest sum of the normal forces [N]; infinite if it has no bound."""
        return value if value == np.inf else positive_scalar(value, f"{self.full_name()}: largest", unit="N")

    @number
    def gain(self, value: float) -> float:
        """K [1/s]."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    @number
    def damping_ratio(self, value: float) -> float:
        """The zeta of acceleration order."""
        return positive_scalar(value, f"{self.full_name()}: damping ratio")

    def _renew(self) -> None:
        if self.least > self.largest:
            raise InvalidInput(
                f"{self.full_name()}: least = {self.least:g} N must not exceed largest = {self.largest:g} N"
            )

    @property
    def unknowns(self) -> int:
        """Number of its unknown forces."""
        return 6 if self.wrench else 3 * len(self.shape.points)

    @property
    def lengths(self) -> Array | None:
        """The side lengths of its rectangle [m], if it has one."""
        return self._lengths

    def block(self) -> Block:
        """Its unknown forces."""
        if self.wrench:
            names = tuple(f"{kind} {axis}" for kind in ("force", "moment") for axis in AXES)
            return Block(self, self.name, names, ("N",) * 3 + ("N m",) * 3)
        names = tuple(f"{where}{axis}" for where in self.places() for axis in AXES)
        return Block(self, self.name, names, ("N",) * len(names))

    def places(self) -> list[str]:
        """Names of its points in explanations, each followed by a blank; empty if there is only one point."""
        count = 1 if self.wrench else len(self.shape.points)
        return [""] if count == 1 else [f"point {i} " for i in range(count)]

    def slot(self, shared: Workspace) -> Slot:
        """What this contact keeps from tick to tick in a workspace."""
        slot: Slot = shared.kept(self, lambda: Slot(1 if self.wrench else len(self.shape.points)))
        return slot

    def touching(self, shared: Workspace) -> Array:
        """Where it touches in the coordinates of the frame, shape (k, 3) [m]: of what rolls, at the present tick."""
        return self.shape.points if self.radius is None else self.slot(shared).lowest

    # Quantities computed from its forces.

    def forces(self, f: Array, axes: Array) -> Array:
        """Forces in world axes at every point, shape (k, 3) [N]; for a wrench (6,), [N] and [N m] about the centre."""
        world = np.asarray(f.reshape(-1, 3) @ axes[:9].reshape(3, 3))
        return world.ravel() if self.wrench else world

    def normal_forces(self, f: Array) -> Array:
        """Normal force at every point [N]; for a wrench, one number."""
        return f[2:3] if self.wrench else f[2::3]

    def cop(self, f: Array, axes: Array) -> Array:
        """Centre of pressure in the coordinates of the frame, shape (3,) [m]; NaN where nothing presses."""
        n = self.normal_forces(f)
        total = float(n.sum())
        if not total > 0.0:
            return np.full(3, np.nan)
        if not self.wrench:
            down = 0.0 if self.radius is None else self.radius * (axes[6:9] @ axes[9:].reshape(3, 3))
            return np.asarray(n @ self.shape.points / total - down)
        arm = np.array([-f[4], f[3], 0.0]) / total  # along t1 and t2
        return np.asarray(self.shape.centre + arm @ axes[:9].reshape(3, 3) @ axes[9:].reshape(3, 3))

    def __repr__(self) -> str:
        parts = [repr(self.frame)]
        if self.radius is not None:
            parts.append(f"radius={self.radius:g}")
        if self.friction is not None:
            parts.append(f"friction={self.friction:g}")
        if self.name != self.frame:
            parts.append(f"name={self.name!r}")
        return f"Contact({', '.join(parts)})"
