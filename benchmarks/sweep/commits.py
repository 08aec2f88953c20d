"""Runs the present benchmarks on another commit of the library."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from hqp import InvalidInput
from hqp.commands.command import INTERRUPTED
from hqp.files.whole import writable

from ..checkout import HERE, front


def run_commit(revision: str, plan: str) -> Path:
    """Measure the library at a commit; the folder of the run. What is finished already is not measured again.

    In a clone of the repository beside the run, so that what is checked out here stays as it is.

    Raises
    ------
    InvalidInput
        If there is no such commit, or it cannot be measured.
    """
    commit = _git("rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}", what=revision)
    place = Path("out", "benchmarks", "commits", commit[:12]).absolute()
    tree, links = place / "tree", place / "front"
    if not tree.exists():  # whole or not at all, as an interruption may come at any time
        writable(place, [])
        with TemporaryDirectory(dir=place) as part:
            _git("clone", "--quiet", "--shared", "--no-checkout", str(HERE), part, what=revision)
            _git("-C", part, "checkout", "--quiet", "--detach", commit, what=revision)
            Path(part).rename(tree)
            Path(part).mkdir()  # for its end
    environment = front(links, tree)
    folder = place / plan
    command = [sys.executable, "-m", "benchmarks", "run", plan, "-o", str(folder)]
    done = subprocess.run(command, cwd=links, env=environment, stdout=subprocess.DEVNULL, check=False)
    if done.returncode == INTERRUPTED:
        raise KeyboardInterrupt
    if done.returncode:
        raise InvalidInput(f"commit {revision}: it could not be measured, exit code {done.returncode}")
    return folder


def _git(*command: str, what: str) -> str:
    try:
        done = subprocess.run(["git", *command], cwd=HERE, capture_output=True, text=True, check=True)
    except OSError as error:
        raise InvalidInput(f"git: {error.strerror}") from None
    except subprocess.CalledProcessError as error:
        why = error.stderr.strip() or "there is no such commit"
        raise InvalidInput(f"{what!r} is neither the folder of a run nor a commit: {why}") from None
    return done.stdout.strip()
