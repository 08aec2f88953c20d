"""placo at work on a recorded motion, in an interpreter of its own: it knows nothing of this library.

``python placo_script.py motion.npz`` answers lines, ``run FIRST LAST`` and ``split FIRST LAST``, with a line of JSON.
"""

import json
import os
import sys
import time

import numpy as np
import placo

replies = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # what the library itself prints is no reply
given = dict(np.load(sys.argv[1]))
scene = json.loads(str(given["scene"]))

robot = placo.RobotWrapper(scene["urdf"], placo.Flags.ignore_collisions)
solver = robot.make_solver()
solver.dt = scene["dt"]
solver.enable_joint_limits(True)
solver.enable_velocity_limits(True)
solver.mask_fbase(not scene["floating"])

joints = scene["joints"]
places, columns = ([offset(name) for name in joints] for offset in (robot.get_joint_offset, robot.get_joint_v_offset))
base = given["q"].shape[1] - len(joints)
configurations = np.tile(robot.state.q, (len(given["q"]), 1))
configurations[:, :base] = given["q"][:, :base]
configurations[:, places] = given["q"][:, base:]
configurations = list(configurations)

targets = []  # object, attribute, values
postures = None
for number, goal in enumerate(scene["goals"]):
    what, frame, name = goal["what"], goal["frame"], f"task {number}"
    weight = goal["cost"] ** 2
    if what == "posture":
        task = solver.add_joints_task()
        postures = [dict(zip(joints, row, strict=True)) for row in given["posture"].tolist()]
        task.set_joints(postures[0])
        task.configure(name, "soft", weight)
        posture = task
        continue
    positions, rotations = given.get(f"position {frame}"), given.get(f"rotation {frame}")
    if what == "com":
        task = solver.add_com_task(positions[0])
        task.mask.set_axises("xy")
        targets.append((task, "target_world", list(positions)))
    elif what == "position":
        task = solver.add_position_task(frame, positions[0])
        targets.append((task, "target_world", list(positions)))
    elif what == "orientation":
        task = solver.add_orientation_task(frame, rotations[0])
        targets.append((task, "R_world_frame", list(rotations)))
    else:
        transforms = np.tile(np.eye(4), (len(positions), 1, 1))
        transforms[:, :3, :3], transforms[:, :3, 3] = rotations, positions
        task = solver.add_frame_task(frame, transforms[0])
        targets.append((task, "T_world_frame", list(transforms)))
        task.configure(name, "soft", weight, weight)
        continue
    task.configure(name, "soft", weight)


def aim(k):
    for task, attribute, values in targets:
        setattr(task, attribute, values[k])


def run(first, last):
    times, steps = [], []
    for k in range(first, last):
        if postures is not None:  # this one stands still; it moves here only because a step has no gain
            posture.set_joints(postures[k])
        step = None
        start = time.perf_counter_ns()
        try:
            robot.state.q = configurations[k]
            aim(k)
            robot.update_kinematics()
            step = solver.solve(False)
        except RuntimeError:
            pass
        times.append(time.perf_counter_ns() - start)
        steps.append(None if step is None else [*step[: scene["base"]], *step[columns]])
    return {"ns": times, "step": steps}


def split(first, last):
    rows = []
    for k in range(first, last):
        if postures is not None:
            posture.set_joints(postures[k])
        aim(k)
        laps = [time.perf_counter_ns()]
        try:
            robot.state.q = configurations[k]
            robot.update_kinematics()
            laps.append(time.perf_counter_ns())
            solver.solve(False)
            laps.append(time.perf_counter_ns())
            rows.append([laps[1] - laps[0], None, laps[2] - laps[1]])  # rows are written inside the solve
        except RuntimeError:
            rows.append([None] * 3)
    return {"ns": rows}


print("{}", file=replies, flush=True)
for line in sys.stdin:
    command, first, last = line.split()
    print(json.dumps({"run": run, "split": split}[command](int(first), int(last))), file=replies, flush=True)
