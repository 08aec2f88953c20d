"""Input of the wrong kind: refused where it is given, by a message that names it, its value and what is allowed."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from interrupts import heard

import hqp
from hqp import (
    Batch,
    BatchSolver,
    Hierarchy,
    InvalidInput,
    Label,
    Level,
    Settings,
    Solver,
    UnknownBackend,
    certify,
    nearest,
    solve_batch,
)
from hqp.errors import brief
from tasks import (
    Chain,
    Change,
    Circle,
    Controller,
    FrameVelocityLimit,
    Line,
    MinimumTorqueTask,
    MujocoPlant,
    PlanarArm,
    Polynomial,
    PositionTask,
    PostureTask,
    Record,
    Setpoint,
    Stack,
    Turn,
    cubic,
    cycloid,
    from_rpy,
    harmonic,
    manipulability,
    quintic,
    simulate,
    solve_ik,
)

ARM = PlanarArm([0.5, 0.4, 0.3], masses=[1.0, 1.0, 1.0], position_limit=(-3.0, 3.0))
TWO = np.array([1.0, 2.0])


class Mute:
    def __repr__(self) -> str:
        raise RuntimeError("no name")


def hierarchy(n: int = 2) -> Hierarchy:
    return Hierarchy([Level.equality(np.eye(1, n), [1.0], name="reach")])


def task(**options: Any) -> PositionTask:
    return PositionTask([0.5, 0.2], gain=1.0, **options)


def controller(**options: Any) -> Controller:
    return Controller(ARM, task(), dt=0.01, **options)


def refused(call: Callable[[], Any], said: str) -> None:
    with pytest.raises(InvalidInput, match=said):
        call()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: solve_batch(hierarchy()),
            "a batch = Hierarchy of .* is a Hierarchy; it must be a list",
        ),
        (lambda: solve_batch(3), "a batch = 3 is a int; it must be a list of hierarchies"),
        (lambda: Batch.of("ab"), "a batch = 'ab' is a str; it must be a list of hierarchies"),
        (lambda: Batch.of(np.array(1.0)), r"a batch = array\(1.\) is a ndarray; it must be a list of hierarchies"),
        (lambda: hierarchy().with_numbers([1.0] * 5), r"numbers = \[1.0, .*\] is a list; it must be a ndarray"),
        (lambda: hierarchy().with_numbers(None), "numbers = None is a NoneType; it must be a ndarray"),
        (
            lambda: Level.equality([[1.0]], [0.0], labels=np.array(1.0)),
            r"labels = array\(1.\) must be a sequence",
        ),
        (lambda: Solver(damping=3), "damping = 3 must map levels to rules"),
        (lambda: Hierarchy(np.array(1.0)), r"takes a sequence of levels, highest first, not array\(1.\)"),
        (lambda: PostureTask([0.0], joints=3, gain=1.0), "'posture': joints = 3 is a int; it must be a list of joints"),
        (lambda: PostureTask([0.0], joints=[[1]], gain=1.0), r"'posture': joint \[1\] must be a name or a number"),
        (lambda: PostureTask([0.0], joints=[True], gain=1.0), "'posture': joint True must be a name or a number"),
        (lambda: task(mask=3.0), r"mask = \[3.0\]; it must say True or False of x, y, z"),
        (lambda: task(mask=np.array(True)), r"mask = \[array\(True\)\]; it must say True or False of x, y, z"),
        (lambda: solve_ik(ARM, task(), goal=3), "goal = 3 is a int; it must be a list of tasks of the stack"),
        (lambda: simulate(controller(), [0.1] * 3, duration=1.0, changes=3), "changes = 3 is a int; it must be a list"),
        (
            lambda: MinimumTorqueTask(torque_range=np.array(1.0)),
            r"torque range = array\(1.\) must be a pair",
        ),
        (lambda: PlanarArm([1.0], position_limit=np.array(1.0)), r"array\(1.\) must be a pair: lowest and highest"),
        (lambda: Chain(3), "chain: pieces = 3 must be a list of trajectories"),
    ],
)
def test_one_thing_where_several_are_taken(call: Callable[[], Any], said: str) -> None:
    refused(call, said)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: Level([[1.0]], 0.0, 0.0, name=TWO),
            r"name of a level = array\(\[1., 2.\]\) is a ndarray; it must",
        ),
        (lambda: Level.bounds([1.0], [1.0], name=TWO), "name of a level = array.* must be a str"),
        (lambda: Level.equality([[1.0]], [0.0], name=None), "name of a level = None is a NoneType; it must be a str"),
        (lambda: nearest([0.0], np.eye(1), name=TWO), "name of a level = array.* must be a str"),
        (lambda: task(name=TWO), "name of a PositionTask = array.* must be a str"),
        (lambda: Label(TWO), "part of a label = array.* must be a str"),
        (lambda: Settings(time_limit=TWO), r"settings: time_limit = array\(\[1., 2.\]\) must be a real number"),
        (lambda: Settings(time_limit=np.nan), "settings: time_limit = nan must be positive"),
        (lambda: Settings(tolerance=TWO), "settings: tolerance = array.* must be a real number"),
        (lambda: certify(hierarchy(), TWO, unique=TWO), r"unique = array\(\[1., 2.\]\) must be True or False"),
        (lambda: task(reference=TWO), r"reference = array\(\[1., 2.\]\); it must be one of 'world', 'local'"),
        (lambda: task(reference=None), "reference = None; it must be one of 'world', 'local'"),
        (lambda: FrameVelocityLimit(1.0, reference=TWO), r"reference = array.*; it must be one of 'world', 'local'"),
        (lambda: Stack(task()).build(ARM, TWO), r"order = array.*; it must be one of 'velocity', 'acceleration'"),
        (lambda: Stack(task()).build(ARM, "torque"), "order = 'torque'; it must be one of 'velocity', 'acceleration'"),
        (lambda: Stack(task()).build(3, "velocity"), "robot = 3 is a int; a robot has nq, nv and at"),
        (lambda: Stack(task()).build(ARM, "velocity", dt=TWO), r"dt has shape \(2,\); it must be one number"),
        (lambda: from_rpy(0.0, TWO, 0.0), r"pitch has shape \(2,\); it must be one number"),
        (lambda: from_rpy(np.inf, 0.0, 0.0), "roll = inf must be finite"),
        (lambda: hqp.problems.hierarchies(TWO, 1), "unknown family array"),
        (lambda: hqp.backend_info(TWO), "unknown backend array"),
        (lambda: simulate(controller(), TWO, duration=TWO), r"duration has shape \(2,\); it must be one number"),
        (
            lambda: simulate(controller(), [0.1] * 3, duration=1.0, changes=[Change("a", task(), 0.1)]),
            "a change: t is not an array of real numbers",
        ),
        (
            lambda: simulate(controller(), [0.1] * 3, duration=1.0, changes=[Change(0.5, 3, 0.1)]),
            "3 is a int; a stack takes tasks, limits and stacks",
        ),
        (
            lambda: simulate(controller(order="torque"), [0.1] * 3, duration=1.0, plant=3),
            r"plant = 3 is a int; a plant has advance\(q, v, tau, dt\)",
        ),
    ],
)
def test_arrays_and_strangers_where_one_thing_is_taken(call: Callable[[], Any], said: str) -> None:
    refused(call, said)


@pytest.mark.parametrize("law", [cubic, quintic, harmonic, cycloid])
@pytest.mark.parametrize("u", [[1, 2], TWO, "a", None, np.array(0.5), True, 1j])
def test_a_timing_law_takes_one_number(law: Callable[[Any], Any], u: Any) -> None:
    refused(lambda: law(u), f"{law.__name__}: u = {re.escape(brief(u))} must be a real number")


@pytest.mark.parametrize(
    "trajectory",
    [
        Line([0.0], [1.0], 1.0),
        Circle([0.0, 0.0], 1.0, 1.0),
        Polynomial(np.zeros((1, 2)), np.ones((1, 2)), 1.0),
        Turn(np.eye(3), np.eye(3), 1.0),
        Chain([Line([0.0], [1.0], 1.0)]),
    ],
    ids=lambda trajectory: type(trajectory).__name__,
)
@pytest.mark.parametrize("t", ["a", None, [0.5]])
def test_a_trajectory_takes_one_time(trajectory: Callable[[Any], Any], t: Any) -> None:
    refused(lambda: trajectory(t), f"t = {re.escape(brief(t))} must be a real number")


def test_numbers_of_other_types_are_numbers() -> None:
    for u in 1, np.float32(0.5), np.int8(0), 0.25:
        assert cubic(u) == cubic(float(u))
    assert Settings(time_limit=np.float64(np.inf)).time_limit == np.inf
    assert Level([[1.0]], 0.0, 0.0, name=np.str_("own")).name == "own"
    assert PostureTask([0.0], joints=np.array([1]), gain=1.0).joints == (1,)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: Hierarchy([], n=10**9), "n = 1000000000 must be an integer of at most 1000000"),
        (lambda: Batch(hierarchy(), 2**30), "count = 1073741824 must be an integer of at most"),
        (lambda: BatchSolver(threads=2**20), "threads = 1048576 must be an integer of at most 1024"),
        (lambda: task(frame=10**5000), "frame = a int too long to be written is a int; it must be a str"),
        (lambda: hqp.solve(hierarchy(), backend=10**5000), "unknown backend a int too long to be written"),
        (lambda: hqp.load(10**5000), "path = a int too long to be written must be the name of a file"),
        (lambda: Settings(iterations=10**5000), "iterations = a int too long to be written must be an integer of at m"),
        (lambda: Stack(Mute()), "<Mute instance at .*> is a Mute; a stack takes tasks"),
        (lambda: task() >> 3, "3 is a int; a stack takes tasks"),
        (lambda: Stack(task()).without(10**5000), "a int too long to be written is not in the stack"),
        (lambda: MujocoPlant(10**5000), "robot = a int too long to be written; the physics need"),
        (
            lambda: PositionTask([1e300, 0.0], gain=1.0),
            r"target\[0\] = 1e\+300 must be at most 1e\+15 in size",
        ),
        (lambda: Setpoint([1e300]), r"setpoint\[0\] = 1e\+300 must be at most 1e\+15 in size"),
        (lambda: manipulability(np.eye(2) * 1e300), r"J\[0, 0\] = 1e\+300 must be at most 1e\+15 in size"),
        (lambda: solve_ik(ARM, task(), [1e300, 0.0, 0.0]), r"q0\[0\] = 1e\+300 must be at most 1e\+15 in size"),
        (lambda: Line([0.0], [1.0], 1e-300), "line: duration = 1e-300 s must be at least 1e-15"),
        (lambda: task(weight=1e300), r"weight = 1e\+300 must not be negative, and at most 1e\+15"),
    ],
)
def test_sizes_that_mean_nothing(call: Callable[[], Any], said: str) -> None:
    if "physics" in said:
        pytest.importorskip("mujoco")
    refused(call, said)


def test_an_unknown_backend_is_told_as_one() -> None:
    with pytest.raises(UnknownBackend):
        hqp.Solver(np.ones(2))  # type: ignore[arg-type]


# Files


def packed(path: Path, arrays: dict[str, Any], declared: tuple[int, ...] | None = None) -> Path:
    """An archive of these arrays, A said to be of another shape; a number stands for so many zeros."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
                if name == "A" and declared is not None:
                    header = {"descr": "<f8", "fortran_order": False, "shape": declared}
                    np.lib.format.write_array_header_1_0(stream, header)
                    stream.write(bytes(array.nbytes))
                else:
                    np.lib.format.write_array(stream, array, allow_pickle=False)
    return path


def arrays(n: Any, *, bounds: bool = True) -> dict[str, Any]:
    levels = [{"name": "", "rows": 1, "bounds": bounds}]
    head = {"format": "hqp hierarchy 1", "n": n, "levels": levels}
    one = {"lower": np.zeros(1), "upper": np.ones(1), "weights": np.ones(1), "columns": np.zeros(1, dtype=np.int64)}
    return {"head": np.array(json.dumps(head)), "A": np.zeros((0 if bounds else 1, 3)), **one}


@pytest.mark.parametrize("n", [10_001, 10**6, 10**9, 2**31 - 1, 10**12, -1, 1.5, "3", None, [3]])
def test_an_n_that_the_numbers_of_a_file_do_not_tell(n: Any, tmp_path: Path) -> None:
    parts = arrays(n)
    refused(lambda: hqp.load(packed(tmp_path / "h.npz", parts, (0, n) if n == 10**9 else None)), "n = ")
    if isinstance(n, int):
        text = f"#HierType\n100\n#nVar\n{n}\n#nObj\n1\n#nCtr\n1\n#ObjType\n100\n#OBJECTIVE 0\n1 0.5\n"
        (tmp_path / "h.dat").write_text(text)
        said = f"n = {n} unknowns, of which only 1 numbers tell|#nVar in whole numbers"
        refused(lambda: hqp.lexls.read(tmp_path / "h.dat"), said)


def test_what_would_not_be_read_is_not_written(tmp_path: Path) -> None:
    large = Hierarchy([Level.bounds(0.0, 1.0, indices=[20_000])], n=30_000)
    refused(lambda: hqp.save(tmp_path / "h.npz", large), "n = 30000 unknowns, of which only 1 numbers tell")
    hqp.save(tmp_path / "h.npz", large, np.zeros(30_000))  # which does tell
    assert hqp.load(tmp_path / "h.npz")[0].n == 30_000
    hqp.lexls.write(tmp_path / "h.dat", large, solution=np.zeros(30_000))
    assert hqp.lexls.read(tmp_path / "h.dat").hierarchy.n == 30_000


@pytest.mark.parametrize("read", [hqp.load, Record.load])
def test_an_archive_that_unpacks_to_more_than_it_accounts_for(read: Callable[[Path], Any], tmp_path: Path) -> None:
    """Its members only say so: were they read, the archive would be damaged."""
    bomb = packed(tmp_path / "bomb.npz", {**arrays(3), "A": np.zeros(1000)})
    content = bytearray(bomb.read_bytes())
    at = content.index(b"PK\x01\x02", content.index(b"PK\x01\x02") + 4)  # A, in the directory
    assert content[at + 24 : at + 28] == (8128).to_bytes(4, "little")
    content[at + 24 : at + 28] = (4_000_000_000).to_bytes(4, "little")
    bomb.write_bytes(content)
    refused(lambda: read(bomb), r"its \d+ bytes would unpack to 40\d+; they may to 1073741824")


@pytest.mark.parametrize("declared", [(1, 30_000_000_000), (2**62, 2**62), (1, 2), (0, 3)])
def test_an_array_that_says_to_be_larger_than_it_is(declared: tuple[int, ...], tmp_path: Path) -> None:
    lie = packed(tmp_path / "lie.npz", arrays(3, bounds=False), declared)
    said = r"its member 'A.npy' says to be float64 of shape \(\d+, \d+\), \d+ bytes, but holds 24"
    refused(lambda: hqp.load(lie), said)


def test_large_arrays_are_written_so_that_they_can_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hqp.files.whole.MOST_UNPACKED", 10_000)
    zeros = Hierarchy([Level.equality(np.zeros((500, 100)), 0.0)])
    hqp.save(tmp_path / "h.npz", zeros)
    assert hqp.load(tmp_path / "h.npz")[0].m == 500


# The command, in processes of its own

HQP = [sys.executable, "-c", "from tasks.cli import main; main()"]


@pytest.fixture
def file(tmp_path: Path) -> str:
    hqp.save(tmp_path / "h.npz", hierarchy())
    return str(tmp_path / "h.npz")


def shell(line: str, *words: str) -> tuple[int, str]:
    """What a line of the shell ends with, `hqp` in it, and what it tells on stderr."""
    command = f'hqp() {{ "$@"; }}; set -o pipefail; {line}'
    done = subprocess.run(["bash", "-c", command, "bash", *HQP, *words], capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


@pytest.mark.parametrize("words", [["solve", "FILE"], ["backends"], ["--help"]], ids=lambda words: words[0])
@pytest.mark.parametrize(
    ("line", "code"),
    [
        ('hqp "$@" >&-', 0),
        ('hqp "$@" >&- 2>&- <&-', 0),
        ('hqp "$@" | head -c0', 141),
        ('hqp "$@" | head -c1 >/dev/null', (0, 141)),
    ],
)
def test_a_stdout_that_is_closed_or_not_read(words: list[str], line: str, code: Any, file: str) -> None:
    ended, told = shell(line, *(file if word == "FILE" else word for word in words))
    assert ended in (code if isinstance(code, tuple) else (code,))
    assert told == ""


@pytest.mark.parametrize("line", ['hqp "$@" 2>&-', 'hqp "$@" 2>&1 >/dev/null | head -c0', 'hqp "$@" >&- 2>&-'])
def test_a_stderr_that_is_closed_or_not_read(line: str) -> None:
    assert shell(line, "solve", "nowhere.npz")[0] == 2


def test_a_full_disk_is_one_line(file: str) -> None:
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full")
    assert shell('hqp "$@" >/dev/full', "solve", file) == (2, "hqp: No space left on device\n")


def test_the_command_begins_before_anything_is_imported() -> None:
    """So that an interruption of the imports is its own."""
    code = "import tasks.cli, sys; print([m for m in ('numpy', 'typer', 'scipy', 'hqp._all') if m in sys.modules])"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "[]\n"


@pytest.mark.parametrize("where", ["numpy", "typer", "hqp.hierarchy", "numba"])
def test_an_interruption_of_the_imports_is_one_line_and_code_130(where: str, file: str) -> None:
    """Also where the module that is interrupted makes another error of it."""
    code = f"""
import os, signal, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {where!r}:
            sys.meta_path.remove(self)
            try:
                os.kill(os.getpid(), signal.SIGINT)
                import time; time.sleep(5)
            except KeyboardInterrupt as error:
                raise ImportError("no module, it seems") from error
sys.meta_path.insert(0, Finder())
from tasks.cli import main
main(["solve", {file!r}])
"""
    with heard():
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "hqp: interrupted; what was finished is kept\n")


@pytest.mark.sweep
def test_an_interruption_at_any_time(file: str) -> None:
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    for wait in np.arange(0.02, 1.5, 0.04):
        with heard():
            process = subprocess.Popen([*HQP, "solve", file], **pipes)
        time.sleep(wait)
        process.send_signal(signal.SIGINT)
        told = process.communicate()[1]
        # Until main has begun, Python itself answers.
        assert process.returncode in (0, 130, -signal.SIGINT)
        assert told in ("", "hqp: interrupted; what was finished is kept\n") or "in run" not in told


@pytest.mark.parametrize("words", [["solve", "BOMB"], ["convert", "BOMB", "out.dat"]], ids=lambda words: words[0])
def test_an_absurd_file_at_the_command(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from tasks.cli import run

    monkeypatch.chdir(tmp_path)
    packed(tmp_path / "BOMB", arrays(10**9))
    assert run(words) == 2
    told = capsys.readouterr().err
    assert "n = 1000000000 unknowns, of which only 1 numbers tell" in told
    assert told.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--position", "1e300,0,0"], r"--position\[0\] = 1e+300 must be at most 1e+15 in size"),
        (["--position", "nan,0,0"], "--position[0] = nan must be finite"),
        (["--position", "0,inf,0"], "--position[1] = inf must be finite"),
        (["--position", "0,0,0", "--orientation", "0,1e300,0"], "--orientation[1] = 1e+300 must be at most 1e+15"),
        (["--position", "0,0,0", "--tolerance", "1e-300"], "tolerance = 1e-300 must be at least 1e-15"),
        (["--position", "0,0,0", "--tolerance", "nan"], "tolerance = nan must be positive"),
    ],
)
def test_absurd_places_at_the_command(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pinocchio")
    from tasks.cli import run

    assert run(["ik", "ur5", *words]) == 2
    told = capsys.readouterr().err
    assert said.replace("\\", "") in told
    assert told.count("\n") == 1


def test_far_places_at_the_command_are_not_reached_and_no_warning(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pinocchio")
    from tasks.cli import run

    assert run(["ik", "ur5", "--position", "1e15,-1e15,1e15", "--iterations", "20"]) == 1
    assert capsys.readouterr().err == ""


def test_memory_that_there_is_not_is_one_line(
    file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from tasks.cli import run

    def full(*_: Any, **__: Any) -> None:
        raise MemoryError("Unable to allocate 224. GiB")

    monkeypatch.setattr(hqp.Solver, "solve", full)
    assert run(["solve", file]) == 2
    assert capsys.readouterr().err == "hqp: it takes more memory than there is: Unable to allocate 224. GiB\n"
