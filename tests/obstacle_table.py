"""The table of docs/obstacles.md: 200 random scenes with a limit, with a task and with neither above the tip.

``python tests/obstacle_table.py``
"""

from __future__ import annotations

import numpy as np
from test_obstacles import KEPT, kept

SCENES = 200
#: How near the tip is to its goal at the end, to count as there [m].
THERE = 5e-3

if __name__ == "__main__":
    for kind in ("none", "task", "limit"):
        spare, off = np.array([kept(seed, kind) for seed in range(SCENES)]).T
        margin, there = np.count_nonzero(spare >= -KEPT), np.count_nonzero(off < THERE)
        print(f"{kind:5}  margin kept {margin}, worst {1e3 * spare.min():+.1f} mm, tip at its goal {there} of {SCENES}")
