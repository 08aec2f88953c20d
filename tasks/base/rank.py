"""The tolerance at which a Jacobian has lost rank."""

from __future__ import annotations

#: Singular values up to this share of the largest count as zero.
RANK_TOLERANCE = 1e-9
