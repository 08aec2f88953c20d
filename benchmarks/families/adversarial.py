"""Adversarial hierarchies, each family for one difficulty: those of :mod:`hqp.problems` that are valid input."""

from __future__ import annotations

from hqp.problems import FAMILIES as ADVERSARIES
from hqp.problems import random_hierarchy

from .family import Family, drawn

FAMILIES = (
    Family(
        "adversarial",
        "mixed",
        "n 2-12, up to 6 levels: inequalities, conflicts, duplicates, deficient ranks, integers, weights",
        drawn(random_hierarchy),
    ),
    *(
        Family("adversarial", adversary.name, adversary.about.splitlines()[0].rstrip("."), drawn(adversary.hierarchy))
        for adversary in ADVERSARIES.values()
        if adversary.expect != "refused"
    ),
)
