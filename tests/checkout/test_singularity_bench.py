"""The bench that compares the remedies for singularities."""

from __future__ import annotations

from pathlib import Path

from benchmarks.singular_pictures import draw
from benchmarks.singular_scenes import FASTEST, METHODS, scenes
from benchmarks.singularities import run


def test_what_the_bench_is_to_show(tmp_path: Path):
    """Where two tasks conflict: the strict stack is fast, limits chatter, damping is slow, calm, and tells its cost."""
    scene = next(scene for scene in scenes() if scene.name == "planar arm, conflict")
    runs = {name: run(scene, name) for name in METHODS}
    assert runs["strict"].speed > 20.0
    assert runs["strict, limits"].speed <= FASTEST + 1e-9
    assert runs["strict, limits"].jump > FASTEST
    for name in "fixed damping", "fixed, limits", "by singular value", "filtering", "Chiaverini":
        assert runs[name].jump < 0.5
    assert runs["fixed damping"].speed < 3.0
    assert runs["by error"].speed < FASTEST * 2**0.5  # two levels, each by its bound, and square to each other
    assert runs["by error"].errors("position")[-1] < 0.3 * runs["fixed damping"].errors("position")[-1]
    assert set(runs["fixed damping"].reported) == {"position", "orientation"}
    for each in runs.values():
        assert each.record.certified == each.record.checked
    draw(tmp_path / "runs.png", {scene.name: list(runs.values())})
    assert (tmp_path / "runs.png").stat().st_size > 0
