"""Benchmarks: problem families x backends -> tables. From a checkout: ``python -m benchmarks``."""
