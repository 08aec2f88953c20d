"""The generators make what they promise, and the same for the same seed."""

from __future__ import annotations

import numpy as np

from hqp.problems import random_hierarchy


def test_random_hierarchies_are_reproducible() -> None:
    a, b = (random_hierarchy(np.random.default_rng(5)) for _ in range(2))
    assert a.structure == b.structure
    np.testing.assert_array_equal(a.A, b.A)
    np.testing.assert_array_equal(a.lower, b.lower)


def test_random_hierarchies_hold_everything_that_a_hierarchy_may() -> None:
    seen: set[str] = set()
    for seed in range(400):
        h = random_hierarchy(np.random.default_rng(seed))
        assert h.find_fault() is None
        assert 2 <= h.n <= 12
        assert 1 <= len(h.levels) <= 6
        equal, free = h.lower == h.upper, np.isinf(h.lower) & np.isinf(h.upper)
        norms = h.row_norms()
        units = np.concatenate([h.matrix(k) for k in range(len(h.levels))]) / np.where(norms > 0, norms, 1)[:, None]
        parallel = np.triu(np.abs(units @ units.T), 1) > 1 - 1e-12
        facts = {
            "equality": equal.any(),
            "one-sided": (np.isinf(h.lower) ^ np.isinf(h.upper)).any(),
            "two-sided": (np.isfinite(h.lower) & np.isfinite(h.upper) & ~equal).any(),
            "free": free.any(),
            "zero row": (norms == 0).any(),
            "bounds": (h.columns >= 0).any(),
            "empty level": any(len(level) == 0 for level in h.levels),
            "more rows than unknowns": any(len(level) > h.n for level in h.levels),
            "weights": (h.weights != 1).any(),
            "duplicates": parallel.any(),
            "integers": len(h.A) > 0 and np.all(np.round(h.A) == h.A),
        }
        seen |= {name for name, fact in facts.items() if fact}
    assert seen == set(facts)
