"""Compilation of the kernels: one decorator, so that all are compiled alike.

Plain loops over rows, which are one-dimensional slices that start at 0: this is what LLVM vectorises.
Sums may be reordered (``reassoc``), NaN and infinities keep their meaning. No allocation, no
exception, no ``numpy.linalg``: each would cost time when compiled and when run.
"""

from __future__ import annotations

import hashlib
import logging
from functools import cache
from pathlib import Path

import numba
from numba import config, int64, njit

LOG = logging.getLogger("hqp")

FAST = {"reassoc", "contract", "nsz"}
ENTRY = {"fastmath": FAST, "error_model": "numpy", "nogil": True, "_nrt": False}

#: Whether the interpreter runs the loops, as NUMBA_DISABLE_JIT=1 asks for: to step through them in a debugger.
INTERPRETED = bool(config.DISABLE_JIT)

#: Counters start with it: a literal would have a variant of its own compiled of every kernel that it is handed to.
integer = int64
#: For what other kernels call: no wrapper to call it from Python.
inner = njit(fastmath=FAST, error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False)

#: For what is called in one place alone: a part of its caller, and compiled with it, once.
step = njit(inline="always", fastmath=FAST, error_model="numpy", nogil=True, _nrt=False)


def plain(kernel):
    """The loop for the interpreter, which on a few numbers is quicker; it must not call others."""
    return getattr(kernel, "py_func", kernel)


def entry(function):
    """For what Python calls: kept on disk, if anywhere, and run without the interpreter's lock."""
    try:
        return njit(cache=True, **ENTRY)(function)
    except RuntimeError:  # there is no folder that Numba may write to: compiled by every process for itself
        return njit(**ENTRY)(function)


#: What is set of the index of what Numba keeps: its stamp, its own file, and how it calls the others.
PRIVATE = ("_source_stamp", "_index_path", "_index_name", "_data_name_pattern")

#: All that Python calls.
_ENTRIES = []


def entries(package):
    """The loops of a package that were imported so far and that Python calls."""
    return [kernel for kernel in _ENTRIES if kernel.__module__.startswith(f"{package}.")]


def stamp(kernel):
    """Tie what is kept on disk to the sources of *all* kernels; Numba alone looks at the kernel's own file.

    The places of Numba's own stamp and names are private. Where a version of Numba has not all of them, what is on disk
    could be of other sources: nothing is taken from there and nothing kept.
    """
    _ENTRIES.append(kernel)
    if INTERPRETED or kernel.stats.cache_path is None:
        return kernel
    index = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    missing = [name for name in PRIVATE if not hasattr(index, name)]
    if missing:
        tell_unkept(", ".join(missing))
        _ENTRIES[-1] = kernel = njit(**ENTRY)(kernel.py_func)
        return kernel
    home = _home(Path(kernel.py_func.__code__.co_filename))
    index._source_stamp = _sources(Path(__file__).parents[1]) + _sources(home)
    package = kernel.py_func.__module__.partition(".")[0]
    if package != home.name and (home / "__init__.py").exists():  # what is kept names its modules: one file a name
        index._index_path = str(Path(index._index_path).with_name(f"{package}.{index._index_name}"))
        index._data_name_pattern = f"{package}.{index._data_name_pattern}"
    return kernel


def _home(place):
    """The folder of the package that a module is in, whatever name it was imported under; its own, if it is in none."""
    packages = [folder for folder in place.parents if (folder / "__init__.py").exists()]
    return packages[-1] if packages else place.parent


@cache
def _sources(home):
    """A hash of all kernels in a package: the modules and the folders of that name, or what lies beside one alone."""
    packaged = (home / "__init__.py").exists()
    sources = sorted({*home.rglob("kernels.py"), *home.rglob("kernels/*.py")} if packaged else home.glob("*.py"))
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()


@cache
def tell_unkept(missing):
    """Say once that every process compiles for itself, and why: names that the index of what Numba keeps has not."""
    why = f"Numba {numba.__version__} keeps them in another way than is known here: its index has no {missing}"
    LOG.warning("kernels are compiled anew by every process: %s", why)
