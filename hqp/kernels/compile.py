"""How kernels are compiled: one decorator, so that all agree.

Plain loops over rows, which are one-dimensional slices that start at 0: this is what LLVM vectorises.
Sums may be reordered (``reassoc``), NaN and infinities keep their meaning. No allocation, no
exception, no ``numpy.linalg``: each would cost time when compiled and when run.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from numba import int64, njit

FAST = {"reassoc", "contract", "nsz"}

#: Counters start with it: a literal would have a variant of its own compiled of every kernel that it is handed to.
integer = int64
#: For what other kernels call: no wrapper to call it from Python.
inner = njit(fastmath=FAST, error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False)


def entry(function):
    """For what Python calls: kept on disk, if anywhere, and run without the interpreter's lock."""
    options = {"fastmath": FAST, "error_model": "numpy", "nogil": True, "_nrt": False}
    try:
        return njit(cache=True, **options)(function)
    except RuntimeError:  # there is no folder that Numba may write to: compiled by every process for itself
        return njit(**options)(function)


def stamp(kernel):
    """Tie what is kept on disk to the sources of *all* kernels; Numba alone looks at the kernel's own file."""
    folders = {Path(__file__).parent, Path(kernel.py_func.__code__.co_filename).parent}
    sources = sorted(source for folder in folders for source in folder.glob("*.py"))
    digest = hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()
    index = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if hasattr(index, "_source_stamp"):
        index._source_stamp = digest
    return kernel
