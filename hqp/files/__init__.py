"""Hierarchies in files: numpy's .npz, to the last bit, and the text format of LexLS."""

from .npz import load, save
from .whole import arrays_of, is_archive, writable, write_arrays

__all__ = ["arrays_of", "is_archive", "load", "save", "writable", "write_arrays"]
