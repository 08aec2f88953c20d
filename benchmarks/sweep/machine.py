"""The machine, the packages and the sources that a measurement was made with."""

from __future__ import annotations

import os
import platform
import subprocess
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import hqp
import tasks

#: The packages whose versions are told, as far as they are here.
PACKAGES = (
    *("numpy", "scipy", "numba", "qpsolvers", "proxsuite", "osqp", "daqp", "quadprog", "clarabel", "piqp"),
    *("cvxopt", "ecos", "highspy", "jaxopt", "qpalm", "qpax", "scs", "pin", "example-robot-data", "pin-pink", "mink"),
)
#: What of the benchmarks makes the numbers; the rest only shows them.
_MEASURING = ("families", "methods", "motions", "sweep", "ticks", "settings.py", "timing.py")


@cache
def describe() -> dict[str, str]:
    """Machine and versions: what goes with every result."""
    told = {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "threads": os.environ.get("OMP_NUM_THREADS", "not set"),
        "hqp": hqp.__version__,
        "commit": commit(),
        "sources": sources(),
    }
    return told | {package: found for package in PACKAGES if (found := _version(package))}


@cache
def sources() -> str:
    """Digest of everything that makes the numbers: our own sources and data, and the versions of the packages."""
    here = Path(__file__).parents[1]
    roots = [Path(str(package.__file__)).parent for package in (hqp, tasks)] + [here / name for name in _MEASURING]
    digest = sha256()
    for root in roots:
        for path in sorted(root.rglob("*")) if root.is_dir() else [root]:
            if path.suffix in (".py", ".npz", ".csv"):
                digest.update(f"{root.name}/{path.relative_to(root)}\n".encode() + path.read_bytes())
    for package in PACKAGES:
        digest.update(f"{package} {_version(package)}\n".encode())
    return digest.hexdigest()[:16]


def commit() -> str:
    """The commit of the library, with a plus sign where something is changed; empty outside a repository."""
    here = Path(str(hqp.__file__)).resolve().parent
    try:
        done = [
            subprocess.run(["git", *command], cwd=here, capture_output=True, text=True, check=True, timeout=10).stdout
            for command in (["rev-parse", "--short=12", "HEAD"], ["status", "--porcelain", "--untracked-files=no"])
        ]
    except (OSError, subprocess.SubprocessError):
        return ""
    return done[0].strip() + "+" * bool(done[1].strip())


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
