"""A library at work on a recorded motion, in an interpreter of its own: what runs here knows nothing of `hqp`.

``python FOLDER LIBRARY MOTION.npz`` answers lines, ``run FIRST LAST`` and ``split FIRST LAST``, with a line of JSON.
"""

import json
import os
import sys
import time
from importlib import import_module

import numpy as np

replies = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # what the library itself prints is no reply
package, motion = sys.argv[1:]
given = dict(np.load(motion))
scene = json.loads(str(given.pop("scene")))
library = import_module(f"on_{package}").Library(scene, given, **scene.pop("options"))


def run(first, last):
    """Nanoseconds of each tick, and its steps of all joints [rad], None where it has no answer."""
    times, steps = [], []
    for k in range(first, last):
        library.prepare(k)
        start = time.perf_counter_ns()
        try:
            step = library.step(k)
        except RuntimeError:
            step = None
        times.append(time.perf_counter_ns() - start)
        steps.append(None if step is None else library.ordered(step))
    return {"ns": times, "step": steps}


def split(first, last):
    """Nanoseconds of kinematics, rows and solving, None where they are not told."""
    return {"ns": [library.split(k) for k in range(first, last)]}


print("{}", file=replies, flush=True)
for line in sys.stdin:
    command, first, last = line.split()
    print(json.dumps({"run": run, "split": split}[command](int(first), int(last))), file=replies, flush=True)
