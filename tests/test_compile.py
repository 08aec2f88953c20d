"""The native solver is compiled once, kept where that can be, and runs where it cannot."""

from __future__ import annotations

import ast
import errno
import gc
import importlib
import operator
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from numba.core import compiler_machinery
from numba.core.codegen import JITCodeLibrary

import hqp
import tasks
from hqp import Solver
from hqp.backends import native
from hqp.kernels import collector, compiler, optimised, part, ready, signatures
from hqp.kernels import compile as compiling


def test_without_a_folder_to_write_to_a_kernel_is_compiled_and_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*args, **kwargs):
        raise PermissionError(errno.EACCES, "read-only")

    def double(number):
        return 2 * number

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)  # which Numba tries its folders with
    kernel = compiling.stamp(compiling.entry(double))
    assert kernel(21) == 42


@pytest.mark.parametrize(("decorator", "code"), [(compiling.inner, False), (numba.njit(no_cpython_wrapper=True), True)])
def test_a_kernel_that_others_call_is_optimised_in_these_alone(decorator, code: bool) -> None:
    """Else every function of a deep tree is optimised again by each of its callers, and theirs."""

    @decorator
    def half(number):
        return 0.5 * number

    def quarter(number):
        return half(half(number))

    assert compiling.entry(quarter)(12.0) == 3.0
    (compiled,) = half.overloads.values()
    assert bool(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)) == code


def test_indices_in_kernels_are_taken_as_they_are() -> None:
    """Nothing is chosen by whether they are negative; and Numba counts from the end in all other functions."""

    def entry_of(numbers, place):
        return numbers[place]

    kernel, usual = numba.njit(**compiling.ENTRY)(entry_of), numba.njit(entry_of)
    given, signature = np.arange(3.0), "(float64[::1], int64)"
    for compiled in kernel, usual:
        compiled.compile(signature)
        assert compiled(given, 2) == 2.0
    assert usual(given, -1) == 2.0
    (llvm,), (other,) = (list(compiled.inspect_llvm().values()) for compiled in (kernel, usual))
    assert len(llvm) < len(other)


def from_the_end(source: str, scope: dict[str, object]) -> list[str]:
    """The indices in compiled functions that are negative whatever the numbers are, as -1 or a constant of a module."""
    found = []
    for function in ast.parse(source).body:
        if not isinstance(function, ast.FunctionDef) or not function.decorator_list:
            continue
        for node in ast.walk(function):
            if isinstance(node, ast.Subscript):
                places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
                ends = [end for p in places for end in ([p.lower, p.upper] if isinstance(p, ast.Slice) else [p]) if end]
                found += [ast.unparse(node) for end in ends if is_negative(end, scope)]
    return found


def is_negative(index: ast.expr, scope: dict[str, object]) -> bool:
    """Whether an index is a negative constant, or a name or number with a minus before it."""
    if isinstance(index, ast.UnaryOp) and isinstance(index.op, ast.USub):
        return True
    try:
        value = eval(compile(ast.Expression(index), "", "eval"), {"__builtins__": {}}, scope)
    except (NameError, TypeError):  # of variables
        return False
    return isinstance(value, int) and value < 0


@pytest.mark.parametrize("index", ["-1", "-k", "0, -1", "LAST", "at.LAST", "-2:", "FIRST - 1"])
def test_an_index_from_the_end_is_found(index: str) -> None:
    scope = {"LAST": -1, "at": SimpleNamespace(LAST=-1), "FIRST": 0}
    source = "@inner\ndef f(x, k):\n    return x[{}]\n"
    assert from_the_end(source.format(index), scope)
    for allowed in "0", "k - 1", "-1 - k", "k, 0", "FIRST", "1:", "x[k] - 1":
        assert not from_the_end(source.format(allowed), scope)


def test_no_kernel_counts_from_the_end() -> None:
    """As nothing asks of an index whether it is negative, see above."""
    for package in hqp, tasks:
        home = Path(package.__file__).parent
        for path in sorted({*home.rglob("kernels.py"), *home.rglob("kernels/*.py")}):
            name = ".".join((package.__name__, *path.relative_to(home).with_suffix("").parts))
            scope = vars(importlib.import_module(name.removesuffix(".__init__")))
            assert not from_the_end(path.read_text(encoding="utf-8"), scope), path


@pytest.mark.parametrize("missing", [*optimised.PRIVATE, None])
def test_a_kernel_that_python_calls_is_optimised_once_or_as_numba_does(monkeypatch, missing: str | None) -> None:
    def doubled(number):
        return 2 * number

    runs, by_numba = [], JITCodeLibrary._optimize_final_module
    monkeypatch.setattr(JITCodeLibrary, "_optimize_final_module", lambda self: (runs.append(self), by_numba(self)))
    if missing is not None:
        monkeypatch.setattr(optimised, "binding", SimpleNamespace(**dict.fromkeys(set(optimised.PRIVATE) - {missing})))
    kernel = numba.njit(**compiling.ENTRY)(doubled)  # not kept on disk
    assert kernel(21) == 42
    (compiled,) = kernel.overloads.values()
    assert type(compiled.library) is optimised.Optimised
    assert (compiled.library in runs) == (missing is not None)


@pytest.mark.parametrize("missing", part.PRIVATE)
def test_a_numba_whose_libraries_are_others_compiles_kernels_as_it_does(missing: str) -> None:
    names = dict.fromkeys(set(part.PRIVATE) - {missing})
    assert compiler.pipeline(compiler.PartCompiler, library=SimpleNamespace(**names)) == {}
    assert compiler.pipeline(compiler.PartCompiler, flags=SimpleNamespace) == {}
    assert compiler.pipeline(compiler.PartCompiler, context=SimpleNamespace) == {}
    assert compiler.pipeline(compiler.PartCompiler) == {"pipeline_class": compiler.PartCompiler}


def test_a_kernel_is_compiled_once_for_all_values_of_its_arguments() -> None:
    @compiling.inner
    def power(base, times, inverse=False):
        result = 1.0
        for _ in range(times):
            result *= base
        return 1.0 / result if inverse else result

    def powers(number):
        return power(number, 2) + power(number, 3) + power(number, 1, True) + power(number, inverse=False, times=1)

    assert compiling.entry(powers)(2.0) == 4.0 + 8.0 + 0.5 + 2.0
    assert [str(kind) for kinds in power.overloads for kind in kinds[:2]] == ["float64", "int64"] * 2  # inverse omitted


def test_signatures_are_looked_up_once() -> None:
    """Of Numba's own functions, whether types are inferred or code is written: it tries all ways to call them."""
    asked = []

    class Context(type(numba.core.registry.cpu_target.typing_context)):
        def resolve_function_type(self, function, args, kws):
            asked.append(function)
            return super().resolve_function_type(function, args, kws)

    numba.njit(lambda row: row[0])(np.ones(1))  # so that the functions are registered
    context = Context()
    context.refresh()
    inferring, translating = signatures.remembering(context)
    row, number = numba.float64[::1], numba.int64
    found = inferring.resolve_function_type(operator.getitem, (row, number), {})
    known = translating.resolve_value_type(operator.getitem)
    assert found.return_type == numba.float64
    assert inferring.resolve_function_type(operator.getitem, (row, number), {}) is found
    assert asked == [operator.getitem]
    for _ in range(2):
        assert known.get_call_type(translating, (row, number), {}) == found
        assert inferring.resolve_setitem(row, number, numba.float64).args[0] == row
    assert asked[1:] == [context.resolve_value_type(operator.getitem), operator.setitem]
    assert known.get_impl_key(found) == context.resolve_value_type(operator.getitem).get_impl_key(found)
    assert signatures.remembering(context) == (inferring, translating)


def test_flags_are_equal_where_their_values_are() -> None:
    """Numba keeps the types of operations by them."""
    fast, same, other = (compiler.KernelFlags() for _ in range(3))
    fast.release_gil, same.release_gil = True, True
    same.nrt = compiler.Flags().nrt  # set, to what it is if it is not
    assert fast == same
    assert hash(fast) == hash(same)
    assert fast not in (other, compiler.Flags(fast))
    assert fast.copy() == fast
    assert type(fast.copy()) is compiler.KernelFlags


@pytest.mark.parametrize("given", [(700, 10, 10), (0, 10, 10), (10**6, 3, 3)])
def test_the_collector_looks_rarely_while_kernels_are_compiled(given: tuple[int, int, int]) -> None:
    """And is left as it was, switched off or rarer still, even if compiling fails."""

    class Kernel:
        signatures = ()

        def compile(self, signature):
            seen.append(gc.get_threshold())
            raise OSError(errno.ENOSPC, "a full disk, and no code")

    before, seen = gc.get_threshold(), []
    try:
        gc.set_threshold(*given)
        with pytest.raises(OSError, match="a full disk"):
            ready.make_ready(Kernel(), "a kernel")
        assert gc.get_threshold()[0] == given[0]
    finally:
        gc.set_threshold(*before)
    assert [threshold[0] for threshold in seen] == [collector.RARELY[0] if given[0] == 700 else given[0]]


def test_the_collector_is_left_as_it_was_found_whoever_ends_first() -> None:
    before = gc.get_threshold()
    gc.set_threshold(700, 10, 10)
    try:
        first, second = collector.collected_rarely(), collector.collected_rarely()
        first.__enter__()
        second.__enter__()
        first.__exit__(None, None, None)
        assert gc.get_threshold()[0] == collector.RARELY[0]
        second.__exit__(None, None, None)
        assert gc.get_threshold()[0] == 700
    finally:
        gc.set_threshold(*before)


@pytest.mark.parametrize("name", sorted(compiler.NEEDLESS))
def test_passes_that_kernels_do_not_need_are_known_to_numba(name: str) -> None:
    known = compiler_machinery._pass_registry._registry.values()
    assert name in {entry.pass_inst.name() for entry in known}


HELPER = """
from hqp.kernels.compile import inner

@inner
def factor():
    return {factor}
"""
KERNELS = """
from hqp.kernels.compile import entry, stamp
from helper import factor

@stamp
@entry
def scaled(number):
    '''With a docstring: without it the bytecode is another.'''
    return factor() * number

@stamp
@entry
def shifted(number):
    return factor() + number
"""
#: A Numba which keeps kernels by the date of their own file as ours does, and has no private name in common with it.
WITHOUT_THE_HOOK = """
from numba.core import caching

class Renamed:
    def __init__(self, cache_path, filename_base, source_stamp):
        index = original(cache_path, filename_base, source_stamp)
        self.flush, self.save, self.load = index.flush, index.save, index.load

original, caching.IndexDataCacheFile = caching.IndexDataCacheFile, Renamed
"""
CALL = "from kernels import scaled, shifted; print(scaled(10), shifted(10))"


@pytest.mark.parametrize("hook", [True, False])
def test_another_kernel_changed_is_compiled_anew_though_numba_may_not_see_it(hook: bool, tmp_path: Path) -> None:
    """With the stamp, what is kept is found as long as nothing changed, by ``python -OO`` too; else nothing is."""
    (tmp_path / "kernels.py").write_text(KERNELS)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "NUMBA_DEBUG_CACHE": "1"}
    for factor, found, how in (3, False, "-B"), (3, hook, "-BOO"), (4, False, "-BOO"), (4, hook, "-B"):
        (tmp_path / "helper.py").write_text(HELPER.format(factor=factor))
        script = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{'' if hook else WITHOUT_THE_HOOK}\n{CALL}"
        done = subprocess.run(
            [sys.executable, how, "-c", script], env=environment, capture_output=True, text=True, check=True
        )
        *kept, answers = done.stdout.splitlines()
        assert answers == f"{10 * factor} {10 + factor}"
        assert any("data loaded from" in line for line in kept) == found
        assert any("data saved to" in line for line in kept) == (hook and not found)
        told = done.stderr.splitlines()
        assert len(told) == (not hook)
        assert all(line.startswith("kernels are compiled anew by every process: Numba ") for line in told)


def test_kernels_are_the_same_where_python_leaves_out_assertions() -> None:
    """For what is kept of them is the same file, see above."""
    folders = [Path(package.__file__).parent for package in (hqp, tasks)]
    sources = [path for home in folders for glob in ("kernels.py", "kernels/*.py") for path in home.rglob(glob)]
    assert len(sources) > 50
    for path in sources:
        words = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        assert not any(isinstance(node, ast.Assert) for node in words), path
        assert not any(isinstance(node, ast.Name) and node.id == "__debug__" for node in words), path


@pytest.mark.parametrize("missing", compiling.PRIVATE)
def test_a_numba_without_one_of_the_private_names_keeps_nothing_and_says_which(missing, monkeypatch, caplog) -> None:
    def double(number):
        return 2 * number

    names = dict.fromkeys(set(compiling.PRIVATE) - {missing}, "kept")
    index = SimpleNamespace(**names)
    kept = SimpleNamespace(
        stats=SimpleNamespace(cache_path="folder"), _cache=SimpleNamespace(_cache_file=index), py_func=double
    )
    monkeypatch.setattr(compiling, "_ENTRIES", [])
    compiling.tell_unkept.cache_clear()
    kernel = compiling.stamp(kept)
    assert kernel is not kept
    assert kernel(21) == 42
    assert vars(index) == names  # nothing of it was set
    assert caplog.text.count(f"compiled anew by every process: Numba {numba.__version__}") == 1
    assert f"its index has no {missing}\n" in caplog.text


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


#: Work for several processes, and what of the kernels is ready before it is given to them, and after.
SHARED_OUT = """
import joblib
from hqp.kernels.compile import entries

def ready():
    return {{repr(kernel) for package in ("hqp", "tasks") for kernel in entries(package) if kernel.signatures}}

class Watched(joblib.Parallel):
    def __call__(self, work):
        before.append(ready())
        return super().__call__(work)

before, joblib.Parallel = [], Watched
{work}
assert before[0]
print(sorted(ready() - before[0]))
"""
WORK = {
    "validate": "from hqp.validation.results import run; run(['native'], 1, 0, 1)",
    "thesis": """
from dataclasses import replace
from pathlib import Path
from tasks.thesis import report, scenarios
scenarios.SCENARIOS = {key: replace(one, duration=3.0) for key, one in scenarios.SCENARIOS.items()}
report.report(["4.2", "4.3"], None, Path(folder), processes=1)
""",
}


@pytest.mark.parametrize("name", WORK)
def test_processes_that_share_work_have_nothing_to_compile(name: str, tmp_path: Path) -> None:
    """Each would do so, and tell it, while the first one did it for all."""
    code = f"folder = {str(tmp_path)!r}\n" + SHARED_OUT.format(work=WORK[name])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
