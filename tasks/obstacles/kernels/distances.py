"""Distance, normal and witness point of every pair of a link and an obstacle.

Every shape is a core, the segment between two points (which are one, of a ball), and a radius about it.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at

#: Of all pairs: how many links, obstacles; the addresses of the links' blocks; the links, obstacles and pairs.
LINKS, OBSTACLES, BLOCKS, CAPSULES, SHAPES, FOUND, WORK = range(7)
LENGTH = 7
#: Of a link: where its segment begins and ends in the coordinates of its frame (3,), and its radius.
START, END, LINK_RADIUS, CAPSULE = 0, 3, 6, 7
#: Of an obstacle: radius, the two points of its core; its velocity, acceleration, and way within the next tick (3,).
RADIUS, CORE, VELOCITY, ACCELERATION, SHIFT, SHAPE = 0, 1, 7, 10, 13, 16
#: Of a pair: the distance of the surfaces [m], negative where they overlap; the unit normal from the obstacle to the
#: link; and the witness, the point of the link's core that is nearest.
DISTANCE, NORMAL, WITNESS, PAIR = 0, 1, 4, 7
#: Cores nearer than this have no direction that leads from one to the other [m].
TOUCHING = 1e-12


@inner
def dot(a, i, b, j):
    """Of two vectors (3,)."""
    return a[i] * b[j] + a[i + 1] * b[j + 1] + a[i + 2] * b[j + 2]


@inner
def share(x):
    """The nearest number from 0 to 1."""
    return min(max(x, 0.0), 1.0)


@inner
def closest_points(first, second, work):
    """Where two segments are nearest, a point of each, into work[:6]; work[6:15] is overwritten.

    A point of the first segment that is nearest to the second is at an end, or both are inside their segments;
    C. Ericson, Real-Time Collision Detection (2005), 5.1.9, minimises the same square in s and t.
    """
    for k in range(3):
        work[6 + k], work[9 + k] = first[3 + k] - first[k], second[3 + k] - second[k]
        work[12 + k] = first[k] - second[k]
    uu, uw, ww = dot(work, 6, work, 6), dot(work, 6, work, 9), dot(work, 9, work, 9)
    ug, wg = dot(work, 6, work, 12), dot(work, 9, work, 12)
    across = uu * ww - uw * uw
    # Parallel segments are nearest along a whole piece: begin in the middle of the first.
    s = share((uw * wg - ug * ww) / across) if across > 1e-12 * uu * ww else 0.5
    t = share((uw * s + wg) / ww) if ww > 0.0 else 0.0
    s = share((uw * t - ug) / uu) if uu > 0.0 else 0.0
    for k in range(3):
        work[k], work[3 + k] = first[k] + s * work[6 + k], second[k] + t * work[9 + k]


@inner
def apart(segment, radius, shape, found, work):
    """How far a link and an obstacle are apart."""
    core = shape[CORE : CORE + 6]
    closest_points(segment, core, work)
    for k in range(3):
        found[WITNESS + k], work[6 + k] = work[k], work[k] - work[3 + k]
    D = math.sqrt(dot(work, 6, work, 6))
    if not D > TOUCHING:
        # Where the cores cross no direction leads out; from middle to middle is as good as any.
        for k in range(3):
            work[6 + k] = 0.5 * (segment[k] + segment[3 + k]) - 0.5 * (core[k] + core[3 + k])
    size = math.sqrt(dot(work, 6, work, 6))
    found[DISTANCE] = D - radius - shape[RADIUS]
    for k in range(3):
        found[NORMAL + k] = work[6 + k] / size if size > TOUCHING else (1.0 if k == 0 else 0.0)


@inner
def measure(here):
    """All pairs, the obstacles of the first link first."""
    told = ints(here, 0, LENGTH)
    links, obstacles = told[LINKS], told[OBSTACLES]
    blocks, capsules = ints(told[BLOCKS], 0, links), floats(told[CAPSULES], 0, CAPSULE * links)
    segment, work = floats(told[WORK], 0, 6), floats(told[WORK], 6, 15)
    for i in range(links):
        block, own = floats(blocks[i], 0, at.JACOBIAN), CAPSULE * i
        for r in range(3):
            segment[r] = block[r] + dot(block, at.ROTATION + 3 * r, capsules, own + START)
            segment[3 + r] = block[r] + dot(block, at.ROTATION + 3 * r, capsules, own + END)
        for o in range(obstacles):
            found = floats(told[FOUND], PAIR * (i * obstacles + o), PAIR)
            apart(segment, capsules[own + LINK_RADIUS], floats(told[SHAPES], SHAPE * o, SHAPE), found, work)


@stamp
@entry
def measure_pairs(here):
    """The distances alone."""
    measure(ints(here, 0, 1)[0])
    return 0
