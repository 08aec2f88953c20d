"""``hqp warmup``: compile all kernels ahead of time, as when a machine is set up."""

from __future__ import annotations

#: Why every process compiles for itself; the log says which of the two reasons applies.
UNKEPT = "no folder can be written to, or this Numba has no stamp for what is kept"


def warmup() -> None:
    """Compile all kernels ahead of time.

    Says how long that took and where they are kept; what is compiled already is left as it is.
    """
    from time import perf_counter

    from hqp.backends import native
    from hqp.certificate import judging
    from hqp.kernels.compile import INTERPRETED
    from hqp.kernels.curved import solve_curved
    from hqp.kernels.damped import solve_damped
    from hqp.kernels.judge import judge
    from hqp.kernels.solver import solve
    from hqp.solver import curved

    from ..base import loops
    from ..rows.kernels.law import write_law

    if INTERPRETED:
        print("the interpreter runs all kernels, as NUMBA_DISABLE_JIT asks for: nothing is compiled")
        return
    kernels = (
        ("certificate", judging.warm_up, judge),
        ("native", native.warm_up, solve),
        ("damped", native.warm_up_damped, solve_damped),
        ("curved", curved.warm_up, solve_curved),
        ("rows", loops.warm_up, write_law),
    )
    for name, warm_up, kernel in kernels:
        start = perf_counter()
        done = "compiled" if warm_up() else "already compiled, ready"
        seconds = perf_counter() - start
        folder = kernel.stats.cache_path
        kept = f"kept in {folder}" if folder else f"not kept: {UNKEPT}"
        print(f"{name}: {done} in {seconds:.1f} s; {kept}")
