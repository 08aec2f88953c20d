"""The factor of the members: solutions with its unit triangle, whatever their number."""

from __future__ import annotations

import numpy as np
import pytest
from kernels import compiled, plain

from hqp.kernels import members, orthogonal

NAMES = "substitute", "substitute_back"


@pytest.fixture(scope="module", params=["compiled", "plain"])
def kernels(request):
    return compiled(members, *NAMES) if request.param == "compiled" else plain(orthogonal, members)


@pytest.mark.parametrize("count", range(14))
def test_substitution_solves_with_the_unit_triangle_from_any_row_on(kernels, count):
    """What stands on and above the diagonal, and behind the members, is neither read nor changed."""
    rng = np.random.default_rng(count)
    F = np.where(np.tri(15, k=-1) > 0.0, rng.uniform(-0.5, 0.5, (15, 15)), np.nan)
    L = np.nan_to_num(F[:count, :count]) + np.eye(count)
    right = rng.standard_normal(15)
    known = np.linalg.solve(L, right[:count])
    for first in range(count + 1):
        row = np.r_[known[:first], right[first:]]
        kernels.substitute(F, row, first, count)
        assert np.allclose(row[:count], known, rtol=0.0, atol=1e-12)
        assert (row[count:] == right[count:]).all()
    back = right.copy()
    kernels.substitute_back(F, back, count)
    assert np.allclose(back[:count], np.linalg.solve(L.T, right[:count]), rtol=0.0, atol=1e-12)
    assert (back[count:] == right[count:]).all()
