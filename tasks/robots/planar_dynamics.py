r"""Dynamics of a planar arm, Eq. 4.1: mass matrix, Coriolis matrix and inverse dynamics.

.. math:: \tau = M(q)\,a + C(q, v)\,v

The links are thin uniform rods in a horizontal plane: gravity has no effect.
With the absolute angles :math:`\alpha_i = q_1 + \dots + q_i` and :math:`e_i` the direction of link i,
every point of the arm is a fixed sum of the :math:`e_i`, hence the kinetic energy

.. math::

    T = \tfrac12 \sum_{jk} H_{jk}\, \dot e_j \cdot \dot e_k
      = \tfrac12 \sum_{jk} H_{jk} \cos(\alpha_j - \alpha_k)\, \dot\alpha_j \dot\alpha_k

with constants H that lengths and masses give once: what link k and the links after it carry of the
motion of both,

.. math::

    H_{jj} = \bigl(\tfrac13 m_j + \textstyle\sum_{i>j} m_i\bigr)\, l_j^2, \qquad
    H_{jk} = H_{kj} = \bigl(\tfrac12 m_k + \textstyle\sum_{i>k} m_i\bigr)\, l_j l_k \quad (j < k).

Lagrange's equations in :math:`\alpha` are :math:`\sum_k H_{jk}\bigl(\cos(\alpha_j - \alpha_k)\,\ddot\alpha_k +
\sin(\alpha_j - \alpha_k)\,\dot\alpha_k^2\bigr)`, and with the lower triangle of ones L, :math:`\alpha = L q`,

.. math::

    M = L^T \bigl[H_{jk} \cos(\alpha_j - \alpha_k)\bigr] L, \qquad
    C = L^T \bigl[H_{jk} \sin(\alpha_j - \alpha_k)\, \dot\alpha_k\bigr] L.

Of the many C with the same C v this one makes :math:`\dot M - 2C` skew-symmetric, so that
:math:`\dot T = v^T \tau`: torques alone bring energy in.
"""

from __future__ import annotations

import numpy as np

from ..base.checks import Array


def inertia_constants(lengths: Array, masses: Array) -> Array:
    """The constants H [kg m^2], shape (n, n), of links with these lengths [m] and masses [kg]."""
    after = np.cumsum(masses[::-1])[::-1] - masses
    later = np.maximum.outer(np.arange(len(lengths)), np.arange(len(lengths)))
    carried = (masses / 2 + after)[later]
    np.fill_diagonal(carried, masses / 3 + after)
    return np.multiply.outer(lengths, lengths) * carried


def mass_matrix(H: Array, q: Array) -> Array:
    """M(q) [kg m^2], shape (..., n, n), at joint angles q [rad], shape (..., n)."""
    return _to_joints(H * np.cos(_differences(q)))


def coriolis(H: Array, q: Array, v: Array) -> Array:
    """C(q, v) [kg m^2/s], shape (..., n, n), at joint angles q [rad] and velocities v [rad/s], shape (..., n)."""
    return _to_joints(H * np.sin(_differences(q)) * np.cumsum(v, axis=-1)[..., None, :])


def inverse_dynamics(H: Array, q: Array, v: Array, a: Array) -> Array:
    r"""``M a + C v`` [N m], all arrays of shape (..., n), without forming either matrix.

    Lagrange's equations are :math:`\sum_k H_{jk}\, (e_j' \cdot \ddot e_k)` with :math:`e' = (-\sin, \cos)`;
    joint i turns all links from i on: its torque is the sum of theirs.
    """
    angles, rates, accelerations = (np.cumsum(x, axis=-1) for x in (q, v, a))
    c, s, squares = np.cos(angles), np.sin(angles), rates * rates
    torques = c * ((c * accelerations - s * squares) @ H) + s * ((s * accelerations + c * squares) @ H)
    return np.asarray(np.cumsum(torques[..., ::-1], axis=-1)[..., ::-1])


def kinetic_energy(H: Array, q: Array, v: Array) -> Array:
    """``v^T M v / 2`` [J], shape (...), of q [rad] and v [rad/s], shape (..., n)."""
    angles, rates = np.cumsum(q, axis=-1), np.cumsum(v, axis=-1)
    x, y = -rates * np.sin(angles), rates * np.cos(angles)
    return np.asarray(0.5 * np.sum(x * (x @ H) + y * (y @ H), axis=-1))


def _differences(q: Array) -> Array:
    """``alpha_j - alpha_k``, shape (..., n, n)."""
    angles = np.cumsum(q, axis=-1)
    return np.asarray(angles[..., :, None] - angles[..., None, :])


def _to_joints(X: Array) -> Array:
    """``L^T X L``: entry (j, k) is the sum of the entries from (j, k) on."""
    return np.asarray(np.cumsum(np.cumsum(X[..., ::-1, ::-1], axis=-1), axis=-2)[..., ::-1, ::-1])
