r"""The motion equation of a model, :math:`\tau = M(q)\,a + b(q, v)` (Eq. 4.1), over leading axes.

All functions overwrite the data of the model.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from hqp import InvalidInput
from hqp.arrays import real_array

from ..base.checks import Array


def mass_matrix(model: pin.Model, data: pin.Data, q: Array) -> Array:
    """M [kg m^2; kg m and kg where joints slide], symmetric, shape (..., nv, nv)."""
    one = _by_columns if len(model.mimicking_joints) else _composite
    M = np.empty((*q.shape[:-1], model.nv, model.nv))
    for row, own in zip(q.reshape(-1, model.nq), M.reshape(-1, model.nv, model.nv), strict=True):
        own[:] = one(model, data, row)
    return M


def bias(model: pin.Model, data: pin.Data, q: Array, v: Array) -> Array:
    """b [N m], [N]: Coriolis, centripetal, gravity, shape (..., nv)."""
    rows = zip(q.reshape(-1, model.nq), v.reshape(-1, model.nv), strict=True)
    torques = [np.array(pin.nonLinearEffects(model, data, *row)) for row in rows]
    return np.array(torques).reshape(v.shape)


def inverse_dynamics(model: pin.Model, data: pin.Data, q: Array, v: Array, a: Array) -> Array:
    """tau [N m], [N], shape (..., nv)."""
    if q.ndim == 1:  # the fast path for one tick
        return np.array(pin.rnea(model, data, q, v, a))
    rows = zip(q.reshape(-1, model.nq), v.reshape(-1, model.nv), a.reshape(-1, model.nv), strict=True)
    torques = [np.array(pin.rnea(model, data, *row)) for row in rows]
    return np.array(torques).reshape(a.shape)


def batches_of(robot: Any, **values: ArrayLike) -> list[Array]:
    """Configurations q, and velocities and accelerations of any other name, with the same leading axes.

    Raises
    ------
    InvalidInput
        If an array has a wrong size for the robot, or other leading axes than the first.
    """
    found: list[Array] = []
    for what, value in values.items():
        array, size = real_array(value, what), robot.nq if what == "q" else robot.nv
        if array.shape[-1:] != (size,) or (found and array.shape[:-1] != found[0].shape[:-1]):
            allowed = f"(..., {size})" if not found else str((*found[0].shape[:-1], size))
            raise InvalidInput(f"{what} has shape {array.shape}; {robot!r} takes {allowed}")
        found.append(array)
    return found


def _composite(model: pin.Model, data: pin.Data, q: Array) -> Array:
    """M by the composite rigid body algorithm."""
    upper = np.triu(pin.crba(model, data, q))  # the algorithm fills only the upper triangle
    return np.asarray(upper + np.triu(upper, 1).T)


def _by_columns(model: pin.Model, data: pin.Data, q: Array) -> Array:
    """M by inverse dynamics, one unit acceleration per column: ``crba`` is wrong for models with mimic joints."""
    still = np.zeros(model.nv)
    weight = np.array(pin.rnea(model, data, q, still, still))
    M = np.array([np.array(pin.rnea(model, data, q, still, a)) - weight for a in np.eye(model.nv)])
    return np.asarray(0.5 * (M + M.T))
