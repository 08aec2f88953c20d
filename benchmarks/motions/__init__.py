"""Recorded motions: the states and targets that the problem families of real motions are made of, as data.

``python -m benchmarks.motions`` records them anew, in closed loop with this library. What a solver does later changes
nothing about problems that are recorded.
"""
