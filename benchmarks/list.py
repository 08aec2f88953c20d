"""``python -m benchmarks list``: plans, families, methods, settings, metrics."""

from __future__ import annotations

from importlib.util import find_spec

from hqp.commands.terminal import console

from .extra import required_packages
from .families import FAMILIES
from .methods import METHODS
from .settings import SETTINGS
from .sweep.plans import PLANS
from .tables import show, terminal


def list_() -> None:
    """List all plans, families, methods, settings, metrics and columns of results."""
    required_packages()
    from .analysis.metrics import METRICS
    from .sweep.schema import COLUMNS

    printer = console(120)
    families = {
        key: f"needs {family.needs}, which is not installed: {family.about}"
        if family.needs and find_spec(family.needs) is None
        else family.about
        for key, family in FAMILIES.items()
    }
    methods = {name: method.missing() or method.about for name, method in METHODS.items()}
    for title, about in (
        ("plans", {plan.name: plan.about for plan in PLANS.values()}),
        ("families", families),
        ("methods", methods),
        ("settings", {setting.name: setting.about for setting in SETTINGS.values()}),
        ("metrics", {metric.name: metric.about for metric in METRICS.values()}),
        ("columns of the results", {name: about for name, (_, about) in COLUMNS.items()}),
    ):
        show(printer, terminal(title, [{"name": name, "about": text} for name, text in about.items()]))
