r"""A closed chain: two frames of one robot that are held together, by a pin or by a weld.

Forces f on the first frame and -f on the second, along the axes of the world, keep the loop closed. At velocity order,
and without the motion equation, a loop constrains the motion alone:

.. math:: (J_a - J_b)\, x = h, \qquad G = J_a - J_b .
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.checks import of_type, truth

from ..base.checks import Array, finite, positive_scalar
from ..base.live import number, structure
from ..base.rotations import rotation_matrix
from ..robots.robot import Robot, as_robot, check_frame
from ..rows.expansion import Companions, Setting
from ..rows.loop_task import LoopTask
from ..rows.part import Order, Part
from ..rows.unknowns import Block
from .model import GAIN

if TYPE_CHECKING:
    from ..rows.plan import Plan
    from ..rows.site import Site, Workspace

NAMES = ("x", "y", "z", "about x", "about y", "about z")


class Loop(Part):
    """Two frames of the robot that stay together.

    Parameters
    ----------
    a, b : str
        The two frames.
    at, at_b : array, shape (3,)
        The point of each frame that is held, in the coordinates of that frame [m].
    turns : bool
        Whether one frame may rotate relative to the other, as in a ball joint; if False the orientation is held too.
    rotation : array, shape (3, 3), optional
        If `turns` is False: the axes of a in the coordinates of b (default: as they are at the first tick).
    gain, damping_ratio, weight
        How errors are corrected; see :class:`tasks.Task`.
    name : str, optional
        Default: the names of both.

    Raises
    ------
    InvalidInput
        If both frames are the same; with a robot, if it has no such frame.

    Examples
    --------
    >>> from tasks import Loop
    >>> Loop("left_hand", "right_hand", at=[0.0, 0.0, 0.1], name="tray")
    Loop('left_hand', 'right_hand')
    """

    a: str = structure()
    b: str = structure()
    turns: bool = structure()

    def __init__(
        self,
        a: str,
        b: str,
        *,
        at: ArrayLike = (0.0, 0.0, 0.0),
        at_b: ArrayLike = (0.0, 0.0, 0.0),
        turns: bool = True,
        rotation: ArrayLike | None = None,
        gain: float = GAIN,
        damping_ratio: float = 1.0,
        weight: ArrayLike = 1.0,
        name: str | None = None,
    ) -> None:
        self.a, self.b = of_type(a, str, "frame of a Loop"), of_type(b, str, "frame of a Loop")
        self.name = f"{a} to {b}" if name is None else of_type(name, str, "name of a Loop")
        if a == b:
            raise InvalidInput(f"{self.full_name()}: both frames are {a!r}; a loop holds two together")
        self.at, self.at_b, self.turns = at, at_b, truth(turns, "turns")
        if self.turns and rotation is not None:
            raise InvalidInput(f"{self.full_name()}: a rotation is given, and it turns; give turns=False")
        self.rotation = rotation
        self.gain, self.damping_ratio, self.weight = gain, damping_ratio, weight

    @number
    def at(self, value: ArrayLike) -> Array:
        """The point of the first frame [m]."""
        return self._point(value, "at")

    @number
    def at_b(self, value: ArrayLike) -> Array:
        """The point of the second frame [m]."""
        return self._point(value, "at_b")

    @number
    def rotation(self, value: ArrayLike | None) -> Array | None:
        """The axes of the first frame in the second's, shape (3, 3); None: as they were at the first tick."""
        return None if value is None else rotation_matrix(np.asarray(value), f"{self.full_name()}: rotation")

    @number
    def gain(self, value: float) -> float:
        """K [1/s]."""
        return positive_scalar(value, f"{self.full_name()}: gain", unit="1/s")

    @number
    def damping_ratio(self, value: float) -> float:
        """The zeta of acceleration order."""
        return positive_scalar(value, f"{self.full_name()}: damping ratio")

    @classmethod
    def of(cls, robot: Robot, **options: Any) -> tuple[Loop, ...]:
        """The closed chains in the file of a robot: the ``connect`` and ``weld`` constraints of an MJCF.

        Use them as ``Stack(*Loop.of(robot)) >> task``, or join them on one level by ``+``.

        Parameters
        ----------
        robot : Robot
        **options
            Passed on to each loop.

        Raises
        ------
        InvalidInput
            If `robot` is not a robot.
        """
        closures = getattr(as_robot(robot), "closures", ())
        return tuple(
            cls(
                own.a,
                own.b,
                at=own.at,
                at_b=own.at_b,
                turns=own.rotation is None,
                rotation=own.rotation,
                **({"name": own.name} | options),
            )
            for own in closures
        )

    def held(self, shared: Workspace) -> Array:
        """Whether the axes that it holds have been taken, and these axes, by rows; kept from tick to tick."""
        held: Array = shared.kept(self, lambda: np.zeros(10))
        return held

    def settle(self, shared: Workspace) -> None:
        """Hold the axes that the next tick finds, unless others are given."""
        if self.rotation is None:
            self.held(shared)[0] = 0.0

    def _point(self, value: ArrayLike, what: str) -> Array:
        point = finite(value, f"{self.full_name()}: {what}")
        if point.shape != (3,):
            raise InvalidInput(f"{self.full_name()}: {what} has shape {point.shape}; it must be (3,)")
        return point

    def companions(self, setting: Setting) -> Companions:
        motion = LoopMotion(self)
        if setting.order != "acceleration" or not setting.has_dynamics:
            return Companions((motion,))
        rows = motion.size(setting.robot)
        return Companions((motion,), block=Block(self, self.name, NAMES[:rows], (("N",) * 3 + ("N m",) * 3)[:rows]))

    def forces(self, f: Array) -> Array:
        """Force [N] on the first frame, in world axes; and moment [N m] if the orientation is held too."""
        return f

    def __repr__(self) -> str:
        return f"Loop({self.a!r}, {self.b!r})"


class LoopMotion(LoopTask):
    """The rows of a loop.

    Parameters
    ----------
    loop : Loop
        The loop whose gain, damping ratio and weight are used.
    """

    loop: Loop = structure()

    def __init__(self, loop: Loop) -> None:
        self.loop, self.name, self.rows = loop, loop.name, 3 if loop.turns else 6

    cap: Array | None = structure(None)
    deceleration: float | None = structure(None)

    if not TYPE_CHECKING:  # live numbers are those of the loop

        @property
        def gain(self) -> Array:
            return np.asarray(self.loop.gain)

        @property
        def damping_ratio(self) -> float:
            return self.loop.damping_ratio

        @property
        def weight(self) -> Array:
            return self.loop.weight

    def check(self, robot: Robot, order: Order, dt: float | None) -> None:
        for frame in self.loop.a, self.loop.b:
            check_frame(robot, frame, f"{self.loop.full_name()}: frame")
        self.check_gain(order, dt)

    def row_names(self, robot: Robot) -> list[tuple[str, str]]:
        return [(name, "m" if k < 3 else "rad") for k, name in enumerate(NAMES[: self.size(robot)])]

    def plan(self, site: Site) -> Plan:
        from ..base.loops import Call
        from ..rows.plan import Plan
        from .kernels.loop import write_loop

        shared, loop = site.shared, self.loop
        kept = loop.held(shared)
        if loop.rotation is not None:
            kept[0], kept[1:] = 1.0, loop.rotation.ravel()
        blocks = site.frame(loop.a), site.frame(loop.b)
        where = shared.unknowns.of(loop) if loop in shared.unknowns else slice(shared.n, shared.n)
        G = shared.wrenches[where.start - shared.n : where.stop - shared.n]
        call = Call(write_loop, site.law(self), *blocks, loop.at, loop.at_b, kept, shared.work, G, len(G))
        shared.given.setdefault(id(self), [])[:] = [call]  # other parts read G from it
        return Plan()
