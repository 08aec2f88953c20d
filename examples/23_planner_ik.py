"""`solve_ik` behind the interface of a planner: a goal pose, many solutions of it, and a path that touches nothing."""

import numpy as np

from tasks import Capsule, DistanceLimit, LinkCapsule, PoseTask, load_robot, solve_ik

STEP, MARGIN, SOLUTIONS = 0.1, 0.02, 5  # of any joint [rad]; to keep [m]; how many goals to find
robot = load_robot("panda", lock=["panda_finger_joint1"])
still, rng = np.zeros(robot.nv), np.random.default_rng(0)
post = Capsule([0.5, 0.0, 0.0], [0.5, 0.0, 0.9], 0.05)  # [m], stands between the hand and where it is to go
links = [LinkCapsule("panda_link4", "panda_link5", 0.07), LinkCapsule("panda_link7", "panda_hand_tcp", 0.05)]
clear = DistanceLimit(links, [post], margin=MARGIN, gain=1.0)


def nearest(path):  # to the post, on all of a path [m]
    return min(clear.distances(robot, robot.at(q, still)).min() for q in path)


def free(q):  # what planners call a state validity checker
    return nearest([q]) > 0.9 * MARGIN


def solutions(position, rotation):  # what they call inverse kinematics: distinct ones, that keep the distance
    stack, found = clear >> PoseTask(position, rotation, gain=1.0), []
    for seed in range(20 * SOLUTIONS):
        answer = solve_ik(robot, stack, q0=robot.random(rng), seed=seed, settle=False)
        if answer and free(answer.q) and all(np.abs(answer.q - q).max() > 0.5 for q in found):
            found.append(answer.q)
    return found[:SOLUTIONS]


def grow(tree, target):  # a tree is a list of paths from its root; the nearest goes on until something is touched
    path = min(tree, key=lambda path: np.linalg.norm(path[-1] - target))
    while (far := np.abs(target - path[-1]).max()) > 0.0:
        q = target if far <= STEP else path[-1] + STEP / far * (target - path[-1])
        if not free(q):
            break
        path = [*path, q]
        tree.append(path)
    return path


def connect(start, goals):  # RRT-Connect: two trees in turn, one towards a random point, the other towards its end
    here, there = [[start]], [[q] for q in goals]
    for turn in range(2000):
        path = grow(here, robot.random(rng))
        other = grow(there, path[-1])
        if np.array_equal(path[-1], other[-1]):
            return [*path, *other[-2::-1]] if turn % 2 == 0 else [*other, *path[-2::-1]]
        here, there = there, here
    raise SystemExit("no path was found")


level = robot.at(robot.home, still).frame().rotation
start = solve_ik(robot, clear >> PoseTask([0.5, 0.35, 0.4], level, gain=1.0)).q
goals = solutions([0.5, -0.35, 0.4], level)
path, straight = connect(start, goals), np.linspace(start, goals[0], 50)
print(f"{len(goals)} solutions of the goal; straight to the first: {1e3 * nearest(straight):.0f} mm to the post")
print(f"path to one of them: {len(path)} points, {1e3 * nearest(path):.0f} mm, joints by {STEP} rad a step at most")
