"""Export of a motion as one HTML page with viser's own player."""

from __future__ import annotations

import os

import numpy as np

from hqp import InvalidInput
from hqp.files.names import PAGE, check_name
from hqp.files.whole import write_lines

from ..base.checks import Array, positive_scalar
from ..robots.robot import Robot
from .figure import figure
from .stage import look, open_stage

#: Pictures a second, at most: what a fast screen shows.
MOST_RATE = 240.0


def save_page(path: str | os.PathLike[str], robot: Robot, t: Array, q: Array, rate: float) -> None:
    """Write a motion as a page.

    Parameters
    ----------
    path : path
    robot : Robot
    t : array, shape (states,)
        Times [s].
    q : array, shape (states, nq)
        Configurations.
    rate : float
        Pictures per second.

    Raises
    ------
    InvalidInput
        If the configurations do not fit the robot, there are none, the rate is above `MOST_RATE`, the file is not
        called .html or .htm, or it cannot be written.
    """
    check_name(path, *PAGE)  # before the pictures, which take long
    rate = positive_scalar(rate, "rate", unit="1/s")
    if rate > MOST_RATE:
        raise InvalidInput(f"rate = {rate:g} 1/s; it must be at most {MOST_RATE:g}, as fast as a screen")
    if q.ndim != 2 or q.shape[1] != robot.nq or not len(q):
        raise InvalidInput(f"the configurations have shape {q.shape}; the robot takes (states, {robot.nq})")
    server = open_stage()
    try:
        drawn = figure(server, robot)
        look(server, drawn.bounds)
        drawn.move(q[0])
        recording = server.get_scene_serializer()
        times = np.arange(t[0], t[-1] + 0.5 / rate, 1.0 / rate)
        for k in np.minimum(np.searchsorted(t, times), len(t) - 1):
            drawn.move(q[k])
            recording.insert_sleep(1.0 / rate)
        page = recording.as_html()
    finally:
        server.stop()
    write_lines(path, page.splitlines(), *PAGE)
