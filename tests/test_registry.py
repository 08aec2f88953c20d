"""Backends as data: looked up without importing anything, refused with what is there instead."""

from __future__ import annotations

import subprocess
import sys

import pytest

from hqp import DEFAULT_BACKEND, Hierarchy, Level, Solver, UnknownBackend, available_backends, backend_info, solve
from hqp.backends import ACCURACY, BACKENDS, registry

HEAVY = ("scipy", "matplotlib", "qpsolvers", "proxsuite", "osqp", "joblib", "typer", "rich", "numba", "hqp.qp")


def imported_after(code: str) -> set[str]:
    report = f"import sys; {code}; print(*sys.modules)"
    return set(
        subprocess.run([sys.executable, "-c", report], capture_output=True, text=True, check=True).stdout.split()
    )


@pytest.mark.parametrize(
    "code",
    ["from hqp import solve", "import hqp; hqp.available_backends(); hqp.backend_info('cascade:osqp')", "import tasks"],
)
def test_nothing_heavy_is_imported_until_used(code: str) -> None:
    modules = imported_after(code)
    assert [name for name in HEAVY if name in modules] == []
    assert not {"hqp.backends.cascade", "hqp.backends.native", "hqp.kernels"} & modules


def test_the_closed_form_needs_neither_scipy_nor_a_qp_solver() -> None:
    modules = imported_after(
        "import hqp; hqp.solve(hqp.Hierarchy([hqp.Level.equality([[1.0]], [1.0])]), backend='pseudoinverse')"
    )
    assert [name for name in HEAVY if name in modules] == []


def test_the_core_backends_are_here() -> None:
    core = {"native", "pseudoinverse", "pseudoinverse:joint", "cascade:proxsuite", "cascade:osqp"}
    assert core <= set(available_backends())
    assert DEFAULT_BACKEND == "native"


def test_capabilities_are_data() -> None:
    assert not backend_info("pseudoinverse").inequalities
    assert not backend_info("pseudoinverse:joint").lexicographic
    assert backend_info("cascade:osqp").accuracy == "first-order"
    assert backend_info("cascade:qpsolvers/daqp").qp_solver == "qpsolvers/daqp"
    assert backend_info("daqp").accuracy == "none"
    assert all(info.accuracy in ACCURACY for info in BACKENDS.values())
    assert all(info.install for info in BACKENDS.values() if info.package)


@pytest.mark.parametrize("name", ["nonsense", "", "cascade:", "cascade:qpsolvers/nonsense", None, 3])
def test_an_unknown_backend_lists_the_installed_ones(name: object) -> None:
    h = Hierarchy([Level.equality([[1.0]], [1.0])])
    for attempt in (lambda: solve(h, backend=name), lambda: Solver(name)):  # type: ignore[arg-type]
        with pytest.raises(UnknownBackend) as refusal:
            attempt()
        assert repr(name) in str(refusal.value)
        assert "installed here: native, " in str(refusal.value)


def test_a_missing_package_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_found", lambda package: package != "daqp")
    assert not {"cascade:qpsolvers/daqp", "daqp"} & set(available_backends())
    with pytest.raises(UnknownBackend, match=r"needs the package 'daqp' \(pip install 'daqp'\)"):
        backend_info("cascade:qpsolvers/daqp")


def test_every_solver_that_qpsolvers_can_drive_is_known() -> None:
    import pkgutil

    import qpsolvers.solvers

    theirs = {module.name.rstrip("_") for module in pkgutil.iter_modules(qpsolvers.solvers.__path__)}
    assert theirs <= {info.qp_solver.removeprefix("qpsolvers/") for info in BACKENDS.values()}
