"""The native solver is compiled once, kept where that can be, and runs where it cannot."""

from __future__ import annotations

import errno
import tempfile
from types import SimpleNamespace

import pytest

from hqp import Solver
from hqp.backends import native
from hqp.kernels import compile as compiling


def test_without_a_folder_to_write_to_a_kernel_is_compiled_and_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*args, **kwargs):
        raise PermissionError(errno.EACCES, "read-only")

    def double(number):
        return 2 * number

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)  # which Numba tries its folders with
    kernel = compiling.stamp(compiling.entry(double))
    assert kernel(21) == 42


def test_a_full_disk_does_not_stop_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Kernel:
        def __init__(self, compiled: bool) -> None:
            self.compiled, self.signatures = compiled, []

        def compile(self, signature: str) -> None:
            self.signatures += [signature] * self.compiled
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(native, "kernel", SimpleNamespace(solve=Kernel(compiled=True)))
    native.warm_up()
    monkeypatch.setattr(native, "kernel", SimpleNamespace(solve=Kernel(compiled=False)))
    with pytest.raises(OSError, match="No space"):
        native.warm_up()


def test_its_code_is_ready_when_the_first_solver_is_made() -> None:
    Solver("native")
    assert native.warm_up() is False
