"""Rotations and cross products in loops; rotation matrices are flat arrays (9,), by rows."""

from __future__ import annotations

import math

from hqp.kernels.compile import inner

#: Below this angle [rad] a series is more accurate than the quotient.
SMALL = 1e-4


@inner
def rotation_vector(R, out, first):
    """Write the rotation vector of R [rad], of length 0 .. pi, to out[first:first + 3].

    It follows from the quaternion by Shepperd's method, which is accurate at every angle. At an angle of pi both signs
    are right; one is taken.
    """
    a, b, c, d, e, f, g, h, i = R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]
    trace = a + e + i
    if trace >= a and trace >= e and trace >= i:
        w, x, y, z = 1.0 + trace, h - f, c - g, d - b
    elif a >= e and a >= i:
        w, x, y, z = h - f, 1.0 + a - e - i, b + d, c + g
    elif e >= i:
        w, x, y, z = c - g, b + d, 1.0 + e - a - i, f + h
    else:
        w, x, y, z = d - b, c + g, f + h, 1.0 + i - a - e
    sine = math.sqrt(x * x + y * y + z * z)
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    scale = 2.0 * math.atan2(sine, w) / sine if sine > SMALL * w else 2.0 / w * (1.0 - (sine / w) ** 2 / 3.0)
    out[first], out[first + 1], out[first + 2] = scale * x, scale * y, scale * z


@inner
def turned_back(R, x, y, z, out, first):
    """Write ``R^T (x, y, z)`` to out[first:first + 3]."""
    for k in range(3):
        out[first + k] = R[k] * x + R[3 + k] * y + R[6 + k] * z


@inner
def crossed(a, b, c, x, y, z, scale, out, first):
    """Add ``scale (a, b, c) x (x, y, z)`` to out[first:first + 3]."""
    out[first] += scale * (b * z - c * y)
    out[first + 1] += scale * (c * x - a * z)
    out[first + 2] += scale * (a * y - b * x)
