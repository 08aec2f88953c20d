"""Levels without numbers yet: the structure of the hierarchy that the parts of a stack fill every tick."""

from __future__ import annotations

import numpy as np

from hqp import Label, Level
from hqp.checks import of_type

from ..robots.robot import Robot
from .row_writer import RowWriter
from .tick import Order
from .unknowns import Unknowns


def empty_level(parts: tuple[RowWriter, ...], robot: Robot, order: Order, unknowns: Unknowns) -> Level:
    """One level without numbers yet: plain bounds if all its parts are plain, rows otherwise."""
    name = " + ".join(of_type(part.name, str, f"name of a {type(part).__name__}") for part in parts)
    weights = np.ones(sum(part.size(robot) for part in parts))

    def labels() -> list[Label]:
        return [label for part in parts for label in part.labels(robot, order)]

    zeros = np.zeros(len(weights))
    if all(part.plain for part in parts):
        indices = np.concatenate([p.columns(unknowns, robot) for p in parts])
        return Level.bounds(zeros, zeros, indices=indices, weights=weights, name=name, labels=labels)
    identity = np.eye(unknowns.n)
    A = [identity[p.columns(unknowns, robot)] if p.plain else np.zeros((p.size(robot), unknowns.n)) for p in parts]
    return Level(np.concatenate(A), zeros, zeros, weights=weights, name=name, labels=labels)
