"""Shared by all tests: reproducible hypothesis runs, and one solver a backend."""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

from hqp import available_backends, backend_info

# The machines are shared: no deadline. Derandomised: a red run is red again.
settings.register_profile("hqp", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("hqp")

# pytest-xdist tells its workers a width; the tests mean a pipe that has none.
os.environ.pop("COLUMNS", None)

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
