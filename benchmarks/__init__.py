"""Problem families x methods x settings -> tables and figures. From a checkout: ``python -m benchmarks``."""

from __future__ import annotations

import os

# One thread: solvers are compared, not the libraries below them. Before any of those is loaded.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
