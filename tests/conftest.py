"""Shared by all tests: reproducible hypothesis runs, a compiled kernel, and one solver a backend."""

from __future__ import annotations

import gc
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest
from hypothesis import given, settings
from hypothesis.strategies import none

from hqp import available_backends, backend_info
from hqp.backends import native
from hqp.solver import curved
from tasks.base import loops
from tasks.base import telling as _telling

# The machines are shared: no deadline. Derandomised: a red run is red again.
settings.register_profile("hqp", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("hqp")

# pytest-xdist tells its workers a width; the tests mean a pipe that has none.
os.environ.pop("COLUMNS", None)


#: What makes kernels ready, those first that take longest to compile.
WARM_UPS = loops.warm_up, native.warm_up, native.warm_up_damped, curved.warm_up


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Before pytest-xdist starts its workers, compile on all cores what each of them then loads from disk."""
    if not hasattr(session.config, "workerinput"):
        with ProcessPoolExecutor(mp_context=get_context("spawn")) as processes:
            for ready in [processes.submit(warm_up) for warm_up in WARM_UPS]:
                ready.result()


@given(none())
def one_example(_: None) -> None:
    """With it Hypothesis makes its random numbers, and asks the garbage collector who refers to them."""


def pytest_collection_finish(session: pytest.Session) -> None:
    """Take the objects that imports have made out of garbage collection: it took a sixth of the time of a run."""
    one_example()  # first: the collector does not tell of what is frozen
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000)


#: Backends which take any hierarchy and promise its optimum.
GENERAL = [
    info.name
    for info in map(backend_info, available_backends())
    if info.lexicographic and info.inequalities and info.accuracy != "none"
]


@pytest.fixture(params=GENERAL)
def general_backend(request: pytest.FixtureRequest) -> str:
    """Each backend that takes inequalities, in turn."""
    return str(request.param)


@pytest.fixture
def nothing_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """What another test was told is told again."""
    monkeypatch.setattr(_telling, "_TOLD", set())
