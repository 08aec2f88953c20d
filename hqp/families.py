"""Former path of :mod:`hqp.problems`, kept for one version."""

import warnings

from .problems import FAMILIES, Family, hierarchies

__all__ = ["FAMILIES", "Family", "hierarchies"]

warnings.warn("hqp.families is hqp.problems now", DeprecationWarning, stacklevel=2)
