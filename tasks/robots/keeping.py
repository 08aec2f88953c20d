"""Copying and pickling Pinocchio models.

Pinocchio cannot read back a serialised model with mimic joints: the process aborts. Such a model is therefore stored as
the model without mimic joints, together with the ties to add.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

#: Arrays of a model with one number per velocity or per position.
NUMBERS = (
    "lowerPositionLimit",
    "upperPositionLimit",
    "lowerVelocityLimit",
    "upperVelocityLimit",
    "lowerEffortLimit",
    "upperEffortLimit",
    "armature",
    "damping",
    "friction",
)


@dataclass(frozen=True)
class Recipe:
    """How a model with mimic joints was made.

    Attributes
    ----------
    untied : pinocchio.Model
        The model in which every joint is independent.
    ties : tuple
        For each tie: leader, follower, factor and offset.
    """

    untied: pin.Model
    ties: tuple[tuple[str, str, float, float], ...]

    def model(self) -> pin.Model:
        """The model with its ties, and the limits of the untied model."""
        model = self.untied
        for leader, follower, factor, offset in self.ties:
            model = pin.transformJointIntoMimic(
                model, model.getJointId(leader), model.getJointId(follower), factor, offset
            )
        return model


@dataclass(frozen=True)
class Kept:
    """A model being copied or pickled.

    Attributes
    ----------
    model : pinocchio.Model
    recipe : Recipe or None
        How it was made, if that is known and it has mimic joints.
    """

    model: pin.Model
    recipe: Recipe | None

    def __deepcopy__(self, memo: dict[int, Any]) -> Kept:
        return Kept(pin.Model(self.model), self.recipe)

    def __reduce__(self) -> tuple[Any, ...]:
        model = self.model
        if not len(model.mimicking_joints):
            return _kept, (model,)
        if self.recipe is None:
            raise TypeError(
                f"the model {model.name!r} has joints that follow others, which Pinocchio cannot read again from a"
                " pickle; load its file by load_robot(..., mimic='follow')"
            )
        numbers = {name: np.array(getattr(model, name)) for name in NUMBERS}
        named = {entry.key(): np.array(entry.data()) for entry in model.referenceConfigurations}
        return _tied, (self.recipe, numbers, named)


def _kept(model: pin.Model) -> Kept:
    return Kept(model, None)


def _tied(recipe: Recipe, numbers: dict[str, np.ndarray], named: dict[str, np.ndarray]) -> Kept:
    model = recipe.model()
    for name, own in numbers.items():
        getattr(model, name)[:] = own
    for name, q in named.items():
        model.referenceConfigurations[name] = q
    return Kept(model, recipe)
