"""Recording of motions in closed loop; some ticks are kept, each with the tick before it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hqp import DEFAULT_BACKEND, Hierarchy, Level, Side, Solver
from tasks.thesis.laws import Law
from tasks.thesis.runs import Job, run
from tasks.thesis.scenarios import Scenario, scenario

from ..ticks.scenes import COM, Scene, What
from ..ticks.stream import record
from . import standing
from .data import DRAWS, Entry, Ticks, write_table, write_ticks
from .playback import FIGURES, SCENES, Played, of_figure, of_scene

#: Ticks of a scene from one that is kept to the next: the motion takes 16 s.
EVERY = 50
#: Which targets a task has.
TARGETS: dict[What, tuple[str, ...]] = {
    "position": ("positions",),
    "orientation": ("rotations",),
    "pose": ("positions", "rotations"),
    "com": ("positions",),
    "posture": (),
}


def record_scene(scene: Scene, draws: int = DRAWS) -> Ticks:
    """The ticks that are kept of a scene, or the first ones of them."""
    stream, at = record(scene, draws * EVERY), _kept(draws, EVERY)
    found = {"q": stream.q[at], "v": stream.v[at], "t": scene.dt * at}
    for goal in scene.goals:
        for kind in TARGETS[goal.what]:
            frame = goal.frame or COM
            found[f"{kind}/{frame}"] = getattr(stream, kind)[frame][at]
    return found


def record_figure(figure: Scenario, law: Law) -> Ticks:
    """The ticks that are kept of a scenario of the thesis."""
    job = Job(figure, law, DEFAULT_BACKEND)
    made, at = run(job), _kept(DRAWS, job.ticks // DRAWS)
    return {"q": made.q[at], "v": made.v[at], "t": made.t[at]}


def _kept(draws: int, every: int) -> NDArray[np.intp]:
    """Every so many-th tick, each after the one before it, shape (draws, 2)."""
    now = every * np.arange(1, draws + 1) - 1
    return np.column_stack([now - 1, now])


def record_all(folder: Path, progress: Callable[[str], None]) -> None:
    """Record all families anew: a file a robot, one for the thesis, and the table.

    Raises
    ------
    InvalidInput
        If a file cannot be written.
    MissingPackage
        If Pinocchio or its robots are not installed.
    """
    files: defaultdict[str, dict[str, Ticks]] = defaultdict(dict)
    entries = []
    for name, scene in SCENES.items():
        progress(name)
        found = files[scene.robot][name] = record_scene(scene)
        needs = "" if scene.robot == "planar" else "pinocchio"
        played = of_scene(scene, found)
        entries.append(Entry("motion", name, needs, norm(played), _about(played, scene.about)))
    for name, (number, law) in FIGURES.items():
        progress(name)
        figure = scenario(number)
        found = files["thesis"][name] = record_figure(figure, law)
        played = of_figure(figure, law, found)
        entries.append(Entry("thesis", name, "", norm(played), _about(played, f"figure {number}, {law.title}")))
    for name, (standing_scene, kind) in standing.families().items():
        progress(name)
        file = standing.file_of(standing_scene)
        if standing_scene.name not in files[file]:
            files[file][standing_scene.name] = standing.record_standing(standing_scene)
        stood = kind(standing_scene, files[file][standing_scene.name])
        entries.append(Entry("contacts", name, "pinocchio", norm(stood), _standing_about(stood, standing_scene.about)))
    for file, motions in files.items():
        write_ticks(file, motions, folder)
    write_table(entries, folder)


def norm(played: Played) -> float:
    """Of all finite numbers of all problems, those before them included."""
    numbers = np.array([problem.numbers for draw in range(len(played)) for problem in played.sample(draw)])
    return float(np.linalg.norm(numbers[np.isfinite(numbers)]))


def _about(played: Played, text: str) -> str:
    """What is in a family: sizes, words, and how many joints are at a limit, mean of its draws."""
    problems = [played.sample(draw).now for draw in range(len(played))]
    limits = problems[0].levels[0]
    limited = _joints(limits, np.isfinite(limits.lower) | np.isfinite(limits.upper))
    held = np.mean([at_limit(problem) for problem in problems])
    return f"{_shape(problems[0])}; {text}; {held:.1f} of {limited} joints at a limit"


def _standing_about(played: Played, text: str) -> str:
    """The same of a robot that stands: how many rows are at a bound, mean of its draws."""
    problems = [played.sample(draw).now for draw in range(len(played))]
    pressed = np.mean([standing.pressed(problem) for problem in problems])
    return f"{_shape(problems[0])}; {text}; {pressed:.1f} inequalities at a bound"


def at_limit(problem: Hierarchy) -> int:
    """How many joints are at a limit at the answer; limits are the first level."""
    sides = Solver().solve(problem).levels[0].active
    return _joints(problem.levels[0], sides != Side.INACTIVE)


def _joints(limits: Level, rows: NDArray[np.bool_]) -> int:
    """To how many joints these rows of plain bounds belong."""
    assert limits.indices is not None
    return len(set(limits.indices[rows]))


def _shape(problem: Hierarchy) -> str:
    """As in ``n = 7: 7 bounds | 3 = | 3 = | identity``."""
    return f"n = {problem.n}: {' | '.join(map(_level, problem.levels))}"


def _level(level: Level) -> str:
    equal = (level.lower == level.upper).all()
    if level.A is None:
        return "identity" if equal else f"{len(level)} bounds"
    return f"{len(level)} {'=' if equal else '<>'}"
