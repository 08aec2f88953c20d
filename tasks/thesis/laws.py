r"""Four laws for position prior to orientation, each a stack.

``thesis``
    Eq. 4.8, :math:`\ddot\theta = J_1^\# h_1 + (I - J_1^\# J_1) J_2^\# h_2`, as its own hierarchy
    {J1 a = h1} > {a = J2# h2}: the law by which the text draws its figures.
``strict``
    {J1 a = h1} > {J2 a = h2}: Eq. 3.17 applied to Eq. 4.7. Exact wherever both can be met, and it
    diverges where the orientation goes out of reach (an algorithmic singularity).
``limits``
    The strict stack with joint velocity and acceleration limits above it, one solve a tick: exact
    wherever exact is possible, bounded everywhere. No closed form: it needs inequalities. Past the
    loss of reach it is bang-bang.
``damped``
    The same with damping on the level of the orientation, :math:`\lambda (\ddot\theta + c_1 \dot\theta) = 0` beside
    the task. It keeps the joints off their limits and ends their swinging: in 4.3 one turns back 4 times instead of 14.

Without task priority (even figures) the second level is left out. Eq. 4.8 and the strict stack are
then the same, :math:`\ddot\theta = J_1^\# h_1`. Under joint limits the null space is used for
manipulability (section 2.2): an arm that leaves it alone can be led to a singularity, and limits that
hold it there take the tip off its path (by 32 mm in 4.26).

Beside these, four more, for comparisons (:mod:`tasks.thesis.studies`, :mod:`tasks.thesis.ideas`):

``coasting``
    ``limits`` with :math:`\lambda \ddot\theta = 0` beside the orientation, damping of the acceleration alone. Where
    :math:`J_2` projected has a singular value :math:`\sigma \ll \lambda`, that brakes a speed at the rate
    :math:`c_1 \sigma^2 / (\sigma^2 + \lambda^2)` only, and joints swing on; ``damped`` at the full rate :math:`c_1`.
``resting``
    ``limits`` with least motion as a last level: with four links one direction is free, in which joints once set in
    motion never stop.
``tip-held``
    Joint limits and the tip, without the manipulability below it.
``swapped``
    Orientation before position (section 1.2).
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import hqp
from hqp import Solution
from hqp.backends import BackendInfo
from hqp.backends.pseudoinverse import joint_form

from ..criteria.manipulability import ManipulabilityTask
from ..criteria.motion import MinimumMotionTask
from ..frames.orientation import OrientationTask
from ..frames.position import PositionTask
from ..joints.damping import Damping
from ..joints.joint_motion import JointMotion
from ..limits.acceleration import JointAccelerationLimit
from ..limits.velocity import JointVelocityLimit
from ..rows.part import Stack
from .scenarios import Scenario

#: The rate at which joints that coast are braked [1/s]: over the minute of a run as good as none.
COASTING_GAIN = 1e-9
#: What ``hqp thesis --law`` takes.
NAMES = ("thesis", "strict", "limits", "damped")


@dataclass(frozen=True)
class Law:
    """A control law: a choice of the joint accelerations.

    Attributes
    ----------
    key, title : str
    stack : callable
        Scenario -> Stack, to be solved by any backend that can.
    names : tuple of str
        By which of :data:`NAMES` it is asked for: several where laws coincide.
    inequalities : bool
        Whether the backend must take inequality rows.
    closed_form : str
        The backend that is this law as a formula, or "" if there is none.
    closed_stack : callable, optional
        What the formula takes, where it is not `stack`.
    closed_proof : callable, optional
        The judge of the formula's answers, where it is not their own certificate.
    """

    key: str
    title: str
    stack: Callable[[Scenario], Stack]
    names: tuple[str, ...]
    inequalities: bool = False
    closed_form: str = ""
    closed_stack: Callable[[Scenario], Stack] | None = None
    closed_proof: Callable[[Solution], bool] | None = None

    def refusal(self, backend: BackendInfo) -> str | None:
        """Why this backend cannot show this law, or None if it can."""
        if self.inequalities and not backend.inequalities:
            return f"{self.title}: left out, {backend.name} takes no inequalities"
        if not backend.lexicographic and self.key == "strict":
            return f"{self.title}: left out, {backend.name} answers another hierarchy, Eq. 4.8's"
        return None


def position(scenario: Scenario) -> PositionTask:
    """The first task: the tip on its path."""
    return PositionTask(scenario.path, gain=scenario.position_gain)


def orientation(scenario: Scenario) -> OrientationTask:
    """The second task: the last link at phi."""
    return OrientationTask(scenario.phi if scenario.phi is not None else 0.0, gain=scenario.orientation_gain)


def strict(scenario: Scenario) -> Stack:
    """position >> orientation."""
    first = Stack(position(scenario))
    return first if scenario.phi is None else first >> orientation(scenario)


def projected(scenario: Scenario) -> Stack:
    """position >> the joint motion of the orientation task alone."""
    first = Stack(position(scenario))
    return first if scenario.phi is None else first >> JointMotion(orientation(scenario))


def limits(scenario: Scenario) -> Stack:
    """Joint velocity and acceleration limits."""
    return JointVelocityLimit(scenario.velocity_limit) + JointAccelerationLimit(scenario.acceleration_limit)


def limited(scenario: Scenario) -> Stack:
    """Joint limits >> position >> orientation."""
    return limits(scenario) >> strict(scenario)


def damped(scenario: Scenario) -> Stack:
    """Joint limits >> position >> damped orientation."""
    return limits(scenario) >> position(scenario) >> orientation(scenario) + Damping(scenario.damping)


def coasting(scenario: Scenario) -> Stack:
    """Joint limits >> position >> orientation, with damping of joint accelerations alone, without a velocity term."""
    still = MinimumMotionTask(scenario.damping, gain=COASTING_GAIN)
    return limits(scenario) >> position(scenario) >> orientation(scenario) + still


def resting(scenario: Scenario) -> Stack:
    """Joint limits >> position >> orientation >> least motion."""
    return limited(scenario) >> MinimumMotionTask(gain=scenario.orientation_gain)


def agile(scenario: Scenario) -> Stack:
    """Joint limits >> position >> manipulability of the position task."""
    tip = position(scenario)
    return limits(scenario) >> tip >> ManipulabilityTask(tip, gain=scenario.orientation_gain)


def swapped(scenario: Scenario) -> Stack:
    """Joint limits >> orientation >> damped position: one ``>>`` exchanged (section 1.2)."""
    return limits(scenario) >> orientation(scenario) >> position(scenario) + Damping(scenario.damping)


def _optimal_in_joint_form(solution: Solution) -> bool:
    """Eq. 4.8 is the optimum of its own hierarchy, not of {J1} > {J2}: judge it by that."""
    return hqp.certify(joint_form(solution.hierarchy), solution.x).ok


THESIS = Law(
    "thesis",
    "Eq. 4.8",
    projected,
    ("thesis",),
    closed_form="pseudoinverse:joint",
    closed_stack=strict,
    closed_proof=_optimal_in_joint_form,
)
STRICT = Law("strict", "strict stack", strict, ("strict",), closed_form="pseudoinverse")
LIMITS = Law("limits", "strict, joint limits", limited, ("limits",), inequalities=True)
DAMPED = Law("damped", "strict, limits, damped", damped, ("damped",), inequalities=True)

TIP = Law("tip", "tip alone", strict, ("thesis", "strict"), closed_form="pseudoinverse")
TIP_LIMITS = Law("tip-limits", "tip, limits, manipulability", agile, ("limits", "damped"), inequalities=True)

COASTING = Law("coasting", "strict, limits, coasting", coasting, (), inequalities=True)
RESTING = Law("resting", "strict, limits, least motion", resting, (), inequalities=True)
TIP_HELD = Law("tip-held", "tip, limits", limited, (), inequalities=True)
SWAPPED = Law("swapped", "orientation first", swapped, (), inequalities=True)


def laws_of(scenario: Scenario, names: Collection[str] = NAMES) -> tuple[Law, ...]:
    """The laws that differ in this scenario, four with task priority, two without, as far as they are asked for.

    Raises
    ------
    InvalidInput
        If a name is none of :data:`NAMES`.
    """
    for name in names:
        if name not in NAMES:
            raise hqp.InvalidInput(f"law {name!r} is unknown; available: {', '.join(NAMES)}")
    laws = (TIP, TIP_LIMITS) if scenario.phi is None else (THESIS, STRICT, LIMITS, DAMPED)
    return tuple(law for law in laws if set(law.names) & set(names))
