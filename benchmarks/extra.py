"""Checks that the packages which the sweeps need are installed."""

from __future__ import annotations

from importlib.util import find_spec

from hqp import MissingPackage


def required_packages() -> None:
    """Raise an error if a package that writes or reads the results is not installed.

    Raises
    ------
    MissingPackage
        If one of them is not installed.
    """
    if missing := [package for package in ("pandas", "pyarrow") if find_spec(package) is None]:
        raise MissingPackage(f"{' and '.join(missing)} not installed: python -m pip install -e '.[bench]'")
