"""Backends against known solutions: by hand, see :mod:`.by_hand`, or by construction, see :mod:`.backwards`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..backends.registry import ACCURACY, backend_info
from ..certificate import certify
from ..solver import Solver
from .answer import KnownAnswer
from .backwards import BACKWARDS
from .by_hand import BY_HAND
from .closed_forms import difference

#: All of them.
KNOWN: Sequence[KnownAnswer] = (*BY_HAND, *BACKWARDS)


@dataclass(frozen=True)
class Finding:
    """The result of one backend on one known solution; NaN for what is not known.

    Attributes
    ----------
    name, backend : str
    x, multipliers
        Differences from what is known, relative to its norm.
    residual
        Largest difference of a residual norm from what is known, relative to the largest of them or 1.
    certified, claimed : bool
        Whether the certificate accepts it, and whether the backend itself called it optimal.
    """

    name: str
    backend: str
    x: float
    residual: float
    multipliers: float
    certified: bool
    claimed: bool

    @property
    def allowed(self) -> float:
        """The relative accuracy that the backend's class promises."""
        return ACCURACY[backend_info(self.backend).accuracy]

    @property
    def hit(self) -> bool:
        """Whether the answer is the known one, to 1e-6, or to what the class promises if that is less."""
        worst = np.nanmax([self.x, self.residual, self.multipliers])
        return self.claimed and bool(worst <= (ACCURACY["exact"] if math.isinf(self.allowed) else self.allowed))

    @property
    def ok(self) -> bool:
        """Whether the backend is inside its class."""
        return self.hit or math.isinf(self.allowed)


def check(backend: str) -> list[Finding]:
    """Compare a backend with all of `KNOWN` that it takes.

    Parameters
    ----------
    backend : str
        A name from ``hqp.available_backends()``.
    """
    info, solver, findings = backend_info(backend), Solver(backend), []
    for known in KNOWN:
        posed = known.posed_to(info)
        if posed is None:
            continue
        solution = solver.solve(posed, known.x_ref)
        certificate = certify(known.hierarchy, solution.x, known.x_ref)
        residuals = np.array([level.residual_norm for level in certificate.levels[:-1]])
        findings.append(
            Finding(
                name=known.name,
                backend=info.name,
                x=difference(solution.x, known.x),
                residual=float(np.abs(residuals - known.residuals).max() / max(1.0, known.residuals.max())),
                multipliers=max(
                    (difference(certificate.levels[k].multipliers, each) for k, each in known.multipliers.items()),
                    default=math.nan,
                ),
                certified=certificate.ok,
                claimed=solution.ok,
            )
        )
    return findings
