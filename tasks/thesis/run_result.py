"""The results of one simulated run: a row of numbers a figure, law and backend."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan

#: Joint speed up to which a joint counts as at rest [rad/min], 1 degree a second.
AT_REST = 1.0


@dataclass(frozen=True)
class RunResult:
    """One run in numbers; NaN where a number means nothing.

    Attributes
    ----------
    figure, law, backend : str
    tip_error_mm : float
        Largest distance of the tip from where it should be, from 0.7 of the motion on [mm].
    phi_share : float
        Share of the whole motion in which phi is within 1 degree; what a stopped run missed counts as not.
    phi_peak_deg : float
        Largest error of phi from 0.2 of the motion on [deg].
    peak_speed : float
        Largest joint speed [rad/min].
    end_speed : float
        Largest joint speed where the run ends, which is where the path comes to rest [rad/min].
    peak_acceleration : float
        Largest joint acceleration from 0.2 of the motion on [rad/min^2].
    reversals : int
        How often the joint that does so most often turns back, over the whole motion. Speeds within 1 rad/min of
        zero have no direction.
    turned_deg : float
        Between the extremes of the joint that turns furthest [deg].
    peak_torque : float
        Largest joint torque [N m] (Eq. 4.1).
    least_singular : float
        Smallest singular value of J1 along the motion [m/rad]: how near it comes to a kinematic singularity.
    least_manipulability : float
        Smallest W = sqrt(det(J1 J1^T)) along the motion [m^2] (Eq. 2.2 for two links).
    velocity_excess, acceleration_excess : float
        By how much a joint limit is exceeded at worst [rad/s], [rad/s^2], where the law has limits.
    limited_share : float
        Share of the ticks in which a joint is at a limit.
    diverged_min : float
        When the motion left all bounds [min].
    certified : float
        Share of the checked ticks whose answer is proved optimal.
    difference_rad : float
        Largest difference of a joint angle to the closed form's run, over the ticks of both [rad].
    tick_deg : float
        Largest difference of a joint angle to the same run at twice the tick [deg]. The command holds over a tick,
        whose effect is of first order: what is left at this tick is as much again. NaN for a run that diverges.
    note : str
        Why a run ended early, if not by divergence.
    """

    figure: str
    law: str
    backend: str
    tip_error_mm: float
    phi_share: float
    phi_peak_deg: float
    peak_speed: float
    end_speed: float
    peak_acceleration: float
    reversals: int
    turned_deg: float
    peak_torque: float
    least_singular: float
    least_manipulability: float
    velocity_excess: float
    acceleration_excess: float
    limited_share: float
    diverged_min: float
    certified: float
    difference_rad: float
    tick_deg: float
    note: str = ""

    @property
    def stopped(self) -> bool:
        """Whether the run ended before its time."""
        return bool(self.note) or not isnan(self.diverged_min)

    @property
    def turning(self) -> bool:
        """Whether a joint still turns where the path has come to rest."""
        return not self.stopped and self.end_speed > AT_REST
