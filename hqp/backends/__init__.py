"""How to solve a hierarchy: one file a backend, looked up by name, imported when used."""

from .registry import ACCURACY, BACKENDS, BackendInfo, available_backends, backend_info

__all__ = ["ACCURACY", "BACKENDS", "BackendInfo", "available_backends", "backend_info"]
