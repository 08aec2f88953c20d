"""The ground in MuJoCo, and the model of contacts with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hqp import InvalidInput
from hqp.checks import truth, whole_number

from ..base.checks import finite_scalar, positive_scalar

#: Radius of the spheres at contact points [m]: small, so that they do not roll.
RADIUS = 1e-4


@dataclass(frozen=True)
class Ground:
    """A level floor or table top, which only the points of contacts touch.

    MuJoCo models a contact as a spring and damper along its normal, and friction as a stiff viscous damper: standing
    robots creep. Elliptic cones, a large `ratio` and `noslip` sweeps reduce the creep.

    Parameters
    ----------
    height : float, optional
        Height of its surface [m] (default: that of the lowest contact point at the start).
    friction : float
        mu.
    time_constant : float
        Time constant of the critically damped spring [s]; at least twice the step of the physics. The larger it is, the
        deeper feet sink in.
    ratio : float
        How much harder friction is than the normal force, ``impratio`` of MuJoCo.
    noslip : int
        Number of final sweeps of MuJoCo's solver that remove slip; 0 for none.
    pyramids : bool
        Whether friction cones are pyramids, as is MuJoCo's own default, or else round.

    Raises
    ------
    InvalidInput
        If a number is out of range.

    Examples
    --------
    >>> from tasks import Ground
    >>> Ground(friction=0.6).friction
    0.6
    """

    height: float | None = None
    friction: float = 0.8
    time_constant: float = 0.005
    ratio: float = 10.0
    noslip: int = 3
    pyramids: bool = False

    def __post_init__(self) -> None:
        height = None if self.height is None else finite_scalar(self.height, "Ground: height")
        checked = {
            "height": height,
            "friction": positive_scalar(self.friction, "Ground: friction"),
            "time_constant": positive_scalar(self.time_constant, "Ground: time_constant", unit="s"),
            "ratio": positive_scalar(self.ratio, "Ground: ratio"),
            "noslip": whole_number(self.noslip, "Ground: noslip"),
            "pyramids": truth(self.pyramids, "Ground: pyramids"),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def check_step(self, step: float) -> None:
        """Refuse steps of the physics [s] that its spring is too stiff for.

        Raises
        ------
        InvalidInput
            If the time constant is shorter than twice the step.
        """
        if self.time_constant < 2.0 * step:
            raise InvalidInput(
                f"Ground: time_constant = {self.time_constant:g} s must be at least twice the step of the physics,"
                f" {2.0 * step:g} s"
            )

    def lay(self, specification: Any, mujoco: Any) -> None:
        """Add the ground to a MuJoCo specification, and set the options of the contact solver."""
        option = specification.option
        option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL if self.pyramids else mujoco.mjtCone.mjCONE_ELLIPTIC
        option.impratio, option.noslip_iterations = self.ratio, self.noslip
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)  # misses points after the ground was moved
        specification.worldbody.add_geom(
            name="ground",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 1.0],
            pos=[0.0, 0.0, (self.height or 0.0) - RADIUS],
            contype=0,
            conaffinity=1,
            condim=3,
            priority=1,  # its friction and spring apply to the contact
            friction=[self.friction, 0.005, 1e-4],
            solref=[self.time_constant, 1.0],
        )
