"""Distance, normal and witness point of every pair of a link and an obstacle.

Every shape is a capsule: a core, which is the segment between two points (for a ball, the same point), and a radius.
"""

from __future__ import annotations

import math

from hqp.kernels.compile import entry, inner, stamp
from hqp.kernels.memory import floats, ints

from ...robots.kernels import block as at

#: Table of all pairs: number of links, of obstacles; addresses of the blocks of the links; the links; the obstacles;
#: the pairs (out); work space.
LINKS, OBSTACLES, BLOCKS, CAPSULES, SHAPES, FOUND, WORK = range(7)
LENGTH = 7
#: Link: both ends of its core in the coordinates of its frame (3,), and its radius. CAPSULE is the size.
START, END, LINK_RADIUS, CAPSULE = 0, 3, 6, 7
#: Obstacle: radius, both ends of its core; velocity, acceleration, and motion within the next tick (3,). SHAPE: size.
RADIUS, CORE, VELOCITY, ACCELERATION, SHIFT, SHAPE = 0, 1, 7, 10, 13, 16
#: Pair: distance of the surfaces [m], negative if they overlap; unit normal from the obstacle to the link; the witness,
#: which is the nearest point of the core of the link. PAIR is the size.
DISTANCE, NORMAL, WITNESS, PAIR = 0, 1, 4, 7
#: Cores nearer than this [m] define no normal.
TOUCHING = 1e-12


@inner
def dot(a, i, b, j):
    """The scalar product of a[i:i + 3] and b[j:j + 3]."""
    return a[i] * b[j] + a[i + 1] * b[j + 1] + a[i + 2] * b[j + 2]


@inner
def share(x):
    """x, clipped to the range from 0 to 1."""
    return min(max(x, 0.0), 1.0)


@inner
def closest_points(first, second, work):
    """Write the closest points of two segments, one of each, to work[:6]; overwrites work[6:15].

    A segment (6,) is its two ends. The squared distance is minimised over the parameters s and t of both segments, as
    in C. Ericson, Real-Time Collision Detection (2005), 5.1.9.
    """
    for k in range(3):
        work[6 + k], work[9 + k] = first[3 + k] - first[k], second[3 + k] - second[k]
        work[12 + k] = first[k] - second[k]
    uu, uw, ww = dot(work, 6, work, 6), dot(work, 6, work, 9), dot(work, 9, work, 9)
    ug, wg = dot(work, 6, work, 12), dot(work, 9, work, 12)
    across = uu * ww - uw * uw
    # Parallel segments may have many closest points: start in the middle of the first segment.
    s = share((uw * wg - ug * ww) / across) if across > 1e-12 * uu * ww else 0.5
    t = share((uw * s + wg) / ww) if ww > 0.0 else 0.0
    s = share((uw * t - ug) / uu) if uu > 0.0 else 0.0
    for k in range(3):
        work[k], work[3 + k] = first[k] + s * work[6 + k], second[k] + t * work[9 + k]


@inner
def apart(segment, radius, shape, found, work):
    """Write distance, normal and witness of a link, with the core `segment` (6,), and an obstacle to `found`."""
    core = shape[CORE : CORE + 6]
    closest_points(segment, core, work)
    for k in range(3):
        found[WITNESS + k], work[6 + k] = work[k], work[k] - work[3 + k]
    D = math.sqrt(dot(work, 6, work, 6))
    if not D > TOUCHING:
        # Where the cores cross there is no normal; the direction from middle to middle is as good as any.
        for k in range(3):
            work[6 + k] = 0.5 * (segment[k] + segment[3 + k]) - 0.5 * (core[k] + core[3 + k])
    size = math.sqrt(dot(work, 6, work, 6))
    found[DISTANCE] = D - radius - shape[RADIUS]
    for k in range(3):
        found[NORMAL + k] = work[6 + k] / size if size > TOUCHING else (1.0 if k == 0 else 0.0)


@inner
def measure(here):
    """Measure all pairs, those of the first link with every obstacle first; `here` is the address of their table."""
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
    """Measure all pairs, without rows; the table has the address of the table of the pairs."""
    measure(ints(here, 0, 1)[0])
    return 0
