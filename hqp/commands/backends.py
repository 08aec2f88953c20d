"""``hqp backends``: what is installed, what each can do, what to install for the rest."""

from __future__ import annotations

from .terminal import console


def backends() -> None:
    """List the solver backends.

    Of each: whether it is installed, whether it takes inequalities, and how exact it is.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from ..backends import ACCURACY, BACKENDS
    from ..solver import DEFAULT_BACKEND

    here = Table(title="installed", title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for column in ("backend", "accuracy", "inequalities", "how"):
        here.add_column(column, no_wrap=column == "backend")
    missing = Table(title="not installed", title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for column in ("backend", "to get it"):
        missing.add_column(column, no_wrap=True)
    for info in BACKENDS.values():
        if info.installed:
            default = " (the default)" if info.name == DEFAULT_BACKEND else ""
            here.add_row(info.name, info.accuracy, "yes" if info.inequalities else "no", info.summary + default)
        else:
            missing.add_row(info.name, f"pip install '{info.install}'")
    out = console()
    out.print(here)
    if missing.row_count:
        out.print(missing)
    classes = ", ".join(f"{name} {bound:.0e}" for name, bound in ACCURACY.items())
    out.print(f"accuracy: the largest relative error in x that the class allows, after polish: {classes}")
