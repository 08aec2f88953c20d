"""Hierarchies in files: numpy's .npz, to the last bit, and the text format of LexLS."""

from .npz import load, save

__all__ = ["load", "save"]
