"""``hqp warmup``: have the native solver compiled before it is needed, as when a machine is set up."""

from __future__ import annotations


def warmup() -> None:
    """Compile the native solver ahead of time, or find it compiled; say how long that took and where it is kept."""
    from time import perf_counter

    from hqp.backends.native import warm_up
    from hqp.kernels.solver import solve

    start = perf_counter()
    done = "compiled" if warm_up() else "already compiled, ready"
    seconds = perf_counter() - start
    folder = solve.stats.cache_path
    kept = f"kept in {folder}" if folder else "not kept: there is no folder that can be written to"
    print(f"native: {done} in {seconds:.1f} s; {kept}")
