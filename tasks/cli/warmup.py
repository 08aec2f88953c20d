"""``hqp warmup``: have the kernels compiled before they are needed, as when a machine is set up."""

from __future__ import annotations


def warmup() -> None:
    """Compile all kernels ahead of time, or find them compiled; say how long that took and where they are kept."""
    from time import perf_counter

    from hqp.backends import native
    from hqp.kernels.solver import solve

    from .. import compiled
    from ..kernels.rows import write_rows

    for name, warm_up, kernel in ("native", native.warm_up, solve), ("rows", compiled.warm_up, write_rows):
        start = perf_counter()
        done = "compiled" if warm_up() else "already compiled, ready"
        seconds = perf_counter() - start
        folder = kernel.stats.cache_path
        kept = f"kept in {folder}" if folder else "not kept: there is no folder that can be written to"
        print(f"{name}: {done} in {seconds:.1f} s; {kept}")
