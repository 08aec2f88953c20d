"""Compilation of the kernels: decorators with the same options for all.

Kernels are plain loops over rows, one-dimensional slices that start at 0: LLVM vectorises these, and if one starts
elsewhere, it gathers one number at a time. The longest sums are in :mod:`.lines`. Sums may be reordered (``reassoc``);
NaN and infinities keep their meaning. Kernels do not allocate, raise or call ``numpy.linalg``: each of these would cost
time, both when compiled and when run.
"""

from __future__ import annotations

import hashlib
import logging
from functools import cache
from pathlib import Path

import numba
from numba import config, int64, njit

from .compiler import KernelCompiler, PartCompiler, for_all_values, pipeline

LOG = logging.getLogger("hqp")

FAST = {"reassoc", "contract", "nsz"}
OPTIONS = {"fastmath": FAST, "error_model": "numpy", "nogil": True, "_nrt": False}
ENTRY = OPTIONS | pipeline(KernelCompiler)
PART = OPTIONS | pipeline(PartCompiler) | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

#: Whether the interpreter runs the loops (NUMBA_DISABLE_JIT=1), as for stepping through them in a debugger.
INTERPRETED = bool(config.DISABLE_JIT)

#: Type of counters at their start: Numba would compile a separate variant of every kernel that is given a literal.
integer = int64

#: Decorator of kernels with one single caller: inlined into it, so compiled once.
step = njit(inline="always", **OPTIONS)


def inner(function):
    """Decorator of kernels that only other kernels call: parts of these, compiled once for all values of arguments."""
    return for_all_values(njit(**PART)(function))


def precise(function):
    """As `inner`, with every sum and product rounded by itself and in its place, for what tells round-off."""
    return for_all_values(njit(**PART | {"fastmath": False})(function))


def plain(kernel):
    """The Python function of a kernel, which is quicker for a few numbers; it must not call other kernels."""
    return getattr(kernel, "py_func", kernel)


def entry(function):
    """Decorator of kernels that Python calls: cached on disk where possible, and run without the interpreter's lock."""
    try:
        return njit(cache=True, **ENTRY)(function)
    except RuntimeError:  # Numba may write to no folder: every process compiles for itself
        return njit(**ENTRY)(function)


#: Private attributes of the index of Numba's cache that are set here: its stamp, its file, and the names of data files.
PRIVATE = ("_source_stamp", "_index_path", "_index_name", "_data_name_pattern")

#: All kernels that Python calls.
_ENTRIES = []


def entries(package):
    """The kernels of a package that Python calls, as far as they were imported yet."""
    return [kernel for kernel in _ENTRIES if kernel.__module__.startswith(f"{package}.")]


def stamp(kernel):
    """Decorator that makes the disk cache of an entry depend on the sources of *all* kernels, not its own file alone.

    The attributes that hold Numba's stamp and file names are private (:data:`PRIVATE`). If a version of Numba lacks one
    of them, the cache could be stale: it is then neither read nor written.
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
    _forget_bytecode(kernel._cache)
    package = kernel.py_func.__module__.partition(".")[0]
    if package != home.name and (home / "__init__.py").exists():  # the cache names modules: a file for each import name
        index._index_path = str(Path(index._index_path).with_name(f"{package}.{index._index_name}"))
        index._data_name_pattern = f"{package}.{index._data_name_pattern}"
    return kernel


def _forget_bytecode(cache):
    """Leave the bytecode, which ``python -OO`` changes, out of the keys of Numba's cache: the stamp has all sources."""
    complete = getattr(cache, "_index_key", None)
    if complete is not None:

        def key(signature, codegen):
            *others, (_, closed_over) = complete(signature, codegen)
            return (*others, closed_over)

        cache._index_key = key


def _home(place):
    """The folder of the top package of a module, whatever name it was imported under; without one, the module's own."""
    packages = [folder for folder in place.parents if (folder / "__init__.py").exists()]
    return packages[-1] if packages else place.parent


@cache
def _sources(home):
    """A hash of all kernel sources of a package: its modules and folders ``kernels``; else of all modules in `home`."""
    packaged = (home / "__init__.py").exists()
    sources = sorted({*home.rglob("kernels.py"), *home.rglob("kernels/*.py")} if packaged else home.glob("*.py"))
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()


@cache
def tell_unkept(missing):
    """Warn once that every process compiles for itself; `missing` names the attributes that Numba's index lacks."""
    why = f"Numba {numba.__version__} keeps them in another way than is known here: its index has no {missing}"
    LOG.warning("kernels are compiled anew by every process: %s", why)
