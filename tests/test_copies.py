"""A copy works by itself: it answers as a fresh one would, whatever the original does meanwhile.

And what serves one thread at a time says so where a second one comes, in a thread as in a forked child.
"""

from __future__ import annotations

import copy
import io
import multiprocessing
import os
import pickle
from concurrent.futures import ThreadPoolExecutor

import joblib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hqp import (
    Batch,
    BatchSolver,
    ErrorDamping,
    Hierarchy,
    InUse,
    Level,
    Settings,
    Solver,
    available_backends,
    solve_batch,
)
from tasks import (
    Capsule,
    Contact,
    Controller,
    Damped,
    DistanceLimit,
    JointAccelerationLimit,
    JointLimits,
    LinkCapsule,
    MujocoPlant,
    OrientationTask,
    PlanarArm,
    PoseTask,
    PositionTask,
    PostureTask,
    Record,
    RigidContactPlant,
    SelfCollisionLimit,
    Setpoint,
    Stack,
    load_robot,
    simulate,
)


def through_joblib(value):
    file = io.BytesIO()
    joblib.dump(value, file)
    file.seek(0)
    return joblib.load(file)


COPIES = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "joblib": through_joblib,
}
TICKS = 200


def problems(seed, count=TICKS, n=7):
    """Hierarchies of one structure, each near the last."""
    rng = np.random.default_rng(seed)
    A, B = rng.standard_normal((3, n)), rng.standard_normal((3, n))
    for _ in range(count):
        A, B = (M + 0.1 * rng.standard_normal(M.shape) for M in (A, B))
        yield Hierarchy(
            [
                Level.bounds(-np.ones(n), np.ones(n)),
                Level.equality(A, 2.0 * rng.standard_normal(3)),
                Level(B, rng.standard_normal(3) - 1.0, np.inf),
            ]
        )


# Solvers.


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("backend", available_backends())
def test_a_copied_solver_answers_as_a_fresh_one(backend, how):
    solver = Solver(backend, Settings(iterations=500))
    few = TICKS if backend == "native" else 8
    equalities = backend.startswith("pseudoinverse")
    first, others = ([_only(h, equalities) for h in problems(seed, few)] for seed in (1, 2))
    for h in first[: few // 2]:
        solver.solve(h)
    twin, fresh = COPIES[how](solver), Solver(backend, Settings(iterations=500))
    assert (twin.backend, twin.settings) == (solver.backend, solver.settings)
    for mine, theirs in zip(first, others, strict=True):
        solver.solve(mine)  # the original goes on
        found, expected = twin.solve(theirs), fresh.solve(theirs)
        assert found.status == expected.status
        np.testing.assert_allclose(found.x, expected.x, rtol=0.0, atol=1e-6 if "osqp" in backend else 1e-9)
        if found.ok and backend != "daqp":
            assert found.certify().ok


def _only(h, equalities):
    return Hierarchy([h.levels[1]], n=h.n) if equalities else h


@pytest.mark.parametrize("how", COPIES)
def test_a_copied_solver_of_damped_levels_answers_as_a_fresh_one(how):
    solver = Solver(damping={1: 0.1})
    for h in problems(1, 20):
        solver.solve(h)
    twin, fresh = COPIES[how](solver), Solver(damping={1: 0.1})
    for mine, theirs in zip(problems(1), problems(2), strict=True):
        solver.solve(mine)
        np.testing.assert_allclose(twin.solve(theirs).x, fresh.solve(theirs).x, atol=1e-9)


@pytest.mark.parametrize("how", COPIES)
def test_a_copied_batch_has_levels_of_its_own(how):
    batch = Batch.of(problems(3, 20))
    twin = COPIES[how](batch)
    np.testing.assert_array_equal(twin.numbers, batch.numbers)
    before = batch.numbers.copy()
    twin.levels[1].lower[:] = twin.levels[1].upper[:] = 0.25
    np.testing.assert_array_equal(batch.numbers, before)
    assert twin[3].levels[1].lower[0] == 0.25
    solution = solve_batch(twin)
    assert solution.ok.all()
    assert all(solution[b].certify().ok for b in range(20))
    for b, h in enumerate(problems(3, 20)):
        h.levels[1].lower[:] = h.levels[1].upper[:] = 0.25
        np.testing.assert_allclose(solution.x[b], Solver().solve(h).x, atol=1e-9)


def test_large_arrays_that_joblib_maps_read_only_are_copied():
    batch, h = Batch.of(problems(3, 3)), next(problems(3, 1))
    for value in batch, h:
        state = pickle.loads(pickle.dumps(value))
        state.numbers.flags.writeable = False
        twin = copy.deepcopy(state) if isinstance(value, Batch) else pickle.loads(pickle.dumps(state))
        twin.levels[1].lower[:] = 0.0


@pytest.mark.parametrize("how", COPIES)
def test_a_copied_batch_solver_answers_as_a_fresh_one(how):
    solver = BatchSolver(threads=2)
    mine, theirs = Batch.of(problems(4, 30)), Batch.of(problems(5, 30))
    solver.solve(mine)
    twin = COPIES[how](solver)
    assert twin.threads == 2
    for _ in range(5):
        solver.solve(mine)
        np.testing.assert_allclose(twin.solve(theirs).x, BatchSolver(threads=1).solve(theirs).x, atol=1e-9)
        theirs.levels[1].lower[:] += 0.01
        theirs.levels[1].upper[:] = theirs.levels[1].lower


@pytest.mark.parametrize("how", COPIES)
def test_a_copied_solution_keeps_its_numbers(how):
    h = next(problems(6, 1))
    solution, whole = Solver().solve(h), solve_batch([h])
    twins = COPIES[how](solution), COPIES[how](whole)[0]
    h.levels[1].lower[:] = -9.0
    for twin in twins:
        assert twin.certify().ok
        np.testing.assert_allclose(twin.x, solution.x, atol=1e-12)
        assert str(twin.explain()) == str(solution.explain())


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("damping", ["curvature", None])
@pytest.mark.parametrize("target", [[0.5, 0.4], [1.5, 0.4]], ids=["in reach", "out of reach"])
def test_a_copied_step_tells_what_it_told(how, damping, target):
    arm, _ = planar()
    stack = JointLimits() >> PositionTask(target, gain=3.0) >> OrientationTask(1.0, gain=3.0)
    controller = Controller(arm, stack, dt=0.01, damping=damping)
    step = controller([0.4, 0.9, 0.6])
    twin = COPIES[how](step)
    told = [str(of.certify()) + str(of.explain()) + str(of.relaxed) for of in (step.solution, twin.solution)]
    assert told[0] == told[1]
    np.testing.assert_array_equal(twin.v, step.v)
    np.testing.assert_array_equal(twin.state.q, step.state.q)
    controller([0.1, 0.2, 0.3])
    late = COPIES[how](step).solution  # told only now
    assert str(late.explain()) == str(twin.solution.explain())


# Controllers.


def planar():
    arm = PlanarArm([0.5, 0.4, 0.3], position_limit=(-2.0, 2.0), velocity_limit=2.0, acceleration_limit=20.0)
    return arm, JointLimits() >> PositionTask([0.5, 0.4], gain=3.0) >> OrientationTask(1.0, gain=3.0)


def panda():
    return load_robot("panda", lock=["panda_finger_joint1"]), (
        JointLimits()
        >> PositionTask([0.4, 0.2, 0.4], gain=3.0)
        >> OrientationTask(np.diag([1.0, -1.0, -1.0]), gain=3.0)
        >> PostureTask(load_robot("panda", lock=["panda_finger_joint1"]).home, gain=1.0)
    )


def damped():
    robot, _ = panda()
    return robot, JointLimits() >> Damped(PositionTask([1.5, 0.2, 0.4], gain=3.0), ErrorDamping(2.0))


def obstacles():
    robot, stack = panda()
    links = [LinkCapsule("panda_link4", "panda_link5", 0.06)]
    wall = DistanceLimit(links, [Capsule([0.5, 0.5, 0.0], [0.5, 0.5, 1.0], 0.05)], margin=0.02, gain=3.0)
    return robot, wall + SelfCollisionLimit(margin=0.01, gain=2.0) >> stack


def humanoid():
    robot = load_robot("g1")
    here = robot.at(robot.home, np.zeros(robot.nv)).frame("left_ankle_roll_link")
    stand = PoseTask(here.position, here.rotation, frame="left_ankle_roll_link", gain=5.0)
    reach = PositionTask([0.3, 0.3, 1.0], frame="left_rubber_hand", gain=2.0)
    return robot, JointLimits() >> stand >> reach


def followers():
    robot = load_robot("baxter", mimic="follow")
    frame = "left_gripper"
    return robot, JointLimits() >> PositionTask([0.7, 0.4, 0.3], frame=frame, gain=2.0)


MAKERS = {
    "planar": (planar, {}),
    "planar at acceleration order": (planar, {"order": "acceleration"}),
    "panda": (panda, {}),
    "panda with torques": (panda, {"order": "torque"}),
    "damped": (damped, {}),
    "obstacles": (obstacles, {}),
    "humanoid": (humanoid, {}),
    "followers": (followers, {}),
}


def controller_of(name):
    make, options = MAKERS[name]
    robot, stack = make()
    if options.get("order") == "torque":
        stack = JointLimits() + JointAccelerationLimit(20.0) >> stack.levels[1][0]
    return Controller(robot, stack, dt=0.01, **options)


def states(robot, seed):
    """Random ones about where it begins."""
    rng = np.random.default_rng(seed)
    start = getattr(robot, "home", np.array([0.4, 0.9, 0.6]))
    integrate = getattr(robot, "integrate", np.add)
    q = start
    for k in range(TICKS):
        q = integrate(start if k % 20 == 0 else q, 0.05 * rng.standard_normal(robot.nv))
        yield q, 0.1 * rng.standard_normal(robot.nv), 0.01 * k


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("name", MAKERS)
def test_a_copied_controller_answers_as_a_fresh_one(name, how):
    original, fresh = controller_of(name), controller_of(name)
    for tick, _ in zip(states(original.robot, 1), range(30), strict=False):
        original(*tick)
    twin = COPIES[how](original)
    assert twin.robot is not original.robot
    assert repr(twin) == repr(original)
    for mine, theirs in zip(states(original.robot, 2), states(original.robot, 3), strict=True):
        original(*mine)
        found, expected = twin(*theirs), fresh(*theirs)
        assert found.ok == expected.ok
        np.testing.assert_allclose(found.solution.x, expected.solution.x, rtol=1e-7, atol=1e-7)
        if found.tau is not None:
            np.testing.assert_allclose(found.tau, expected.tau, rtol=1e-6, atol=1e-6)
    assert twin(*theirs).solution.certify().ok


@pytest.mark.parametrize("how", COPIES)
def test_a_controller_that_is_copied_in_a_change_goes_on_with_it(how):
    robot, stack = panda()
    limits, reach, turn, posture = (level[0] for level in stack.levels)
    ways = [limits >> turn >> reach >> posture, limits >> posture, stack]

    def begun():
        controller, q, v = Controller(robot, stack, dt=0.01), robot.home, np.zeros(7)
        for k, way in enumerate(ways):
            controller.change(way, duration=0.5)
            for i in range(3):
                controller(q, v, 0.1 * k + 0.01 * i)
        return controller

    original = begun()
    twin = COPIES[how](original)
    for k in range(60):
        t = 0.3 + 0.01 * k
        mine, theirs = original(robot.home, np.zeros(7), t), twin(robot.home, np.zeros(7), t)
        assert theirs.share == pytest.approx(mine.share)
        np.testing.assert_allclose(theirs.v, mine.v, atol=1e-7)
    assert theirs.share == 1.0


@pytest.mark.parametrize("how", COPIES)
def test_a_copy_keeps_what_contacts_of_other_stacks_keep(how):
    """Those of a stack that it is leaving hold where they did; those of one that it has left are off as they were."""
    robot, _ = panda()
    elbow, rest = Contact("panda_link4", name="elbow"), PostureTask(robot.home, gain=1.0)
    held, free = Stack(elbow) >> rest, Stack(PostureTask(robot.home + 0.1, gain=1.0))
    aside = robot.home + 0.05

    leaving = Controller(robot, held, dt=0.01)
    leaving(robot.home, t=0.0)
    leaving.change(free, duration=1.0)
    leaving(aside, t=0.1)
    twin = COPIES[how](leaving)
    np.testing.assert_allclose(twin(aside, t=0.3).v, leaving(aside, t=0.3).v, atol=1e-9)

    left = Controller(robot, held, dt=0.01)
    left(robot.home)
    left.release("elbow")
    left.change(free, duration=0.0)
    twin, other = COPIES[how]((left, held))
    for controller, stack in (left, held), (twin, other):
        controller.change(stack, duration=0.0)
        assert not controller.bears("elbow")
    np.testing.assert_allclose(twin(aside).v, left(aside).v, atol=1e-9)


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("kind", ["mujoco", "rigid"])
def test_a_copied_plant_goes_on_by_itself(kind, how):
    pytest.importorskip("mujoco", reason="physics need MuJoCo: pip install 'hqp[mujoco]'")
    robot = load_robot("go2")
    feet = [Contact(f"{leg}_foot", name=leg, friction=0.6) for leg in ("FL", "FR", "RL", "RR")]
    plant = MujocoPlant(robot, contacts=feet) if kind == "mujoco" else RigidContactPlant(robot, feet)
    tau = np.full(12, 0.3)
    moved = plant.advance(robot.home, np.zeros(robot.nv), tau, 0.01)
    if kind == "mujoco":
        plant.push("base", [10.0, 0.0, 0.0], 0.015)
    twin, third = COPIES[how](plant), COPIES[how](plant)
    third.advance(*moved, -tau, 0.01)
    for found, expected in zip(twin.advance(*moved, tau, 0.01), plant.advance(*moved, tau, 0.01), strict=True):
        np.testing.assert_array_equal(found, expected)
    for name, force in plant.forces.items():
        np.testing.assert_array_equal(twin.forces[name], force)


def test_copies_of_a_pair_share_what_the_pair_shares():
    """A setpoint beside its controller: copied together they stay together, and apart from the originals."""
    robot, _ = panda()
    hand = Setpoint([0.4, 0.2, 0.4])
    controller = Controller(robot, PositionTask(hand, gain=2.0), dt=0.01)
    twin, own = copy.deepcopy((controller, hand))
    own.move([0.5, 0.0, 0.3])
    expected = Controller(robot, PositionTask([0.5, 0.0, 0.3], gain=2.0), dt=0.01)(robot.home, np.zeros(7)).v
    np.testing.assert_allclose(twin(robot.home, np.zeros(7)).v, expected, atol=1e-9)
    assert np.abs(controller(robot.home, np.zeros(7)).v - expected).max() > 0.1


@pytest.mark.parametrize("how", COPIES)
def test_a_copied_robot_is_itself(how):
    for robot in (panda()[0], load_robot("g1"), load_robot("baxter", mimic="follow"), planar()[0]):
        q = getattr(robot, "home", np.array([0.4, 0.9, 0.6]))
        if hasattr(robot, "geometry"):
            robot.geometry()
        twin = COPIES[how](robot)
        robot.at(0.5 * q, np.zeros(robot.nv)) if robot.nq == robot.nv else None
        for mine, theirs in ((robot.at(q, np.ones(robot.nv)), twin.at(q, np.ones(robot.nv))),):
            frame = robot.frame_names[-1]
            np.testing.assert_array_equal(mine.frame(frame).position, theirs.frame(frame).position)
            np.testing.assert_array_equal(mine.frame(frame).linear_drift, theirs.frame(frame).linear_drift)
        if hasattr(robot, "geometry"):
            assert len(twin.geometry().geometryObjects) == len(robot.geometry().geometryObjects)


@pytest.mark.parametrize("how", COPIES)
def test_a_copied_record_is_itself(how):
    arm, stack = planar()
    record = simulate(Controller(arm, stack, dt=0.01), [0.4, 0.9, 0.6], duration=0.3)
    twin = COPIES[how](record)
    assert isinstance(twin, Record)
    for name in "t", "q", "v", "pose":
        np.testing.assert_array_equal(getattr(twin, name), getattr(record, name))
    assert repr(twin) == repr(record)


def test_one_controller_for_each_environment():
    """The ordinary use: copies in worker processes, each on its own robot."""
    original = controller_of("panda")
    starts = [q for (q, _, _), _ in zip(states(original.robot, 5), range(6), strict=False)]
    alone = [simulate(copy.deepcopy(original), q, duration=0.2, certify=0).q[-1] for q in starts]
    jobs = (joblib.delayed(simulate)(copy.deepcopy(original), q, duration=0.2, certify=0) for q in starts)
    together = joblib.Parallel(n_jobs=2)(jobs)
    np.testing.assert_allclose([record.q[-1] for record in together], alone, atol=1e-8)


# Threads and forks.

TRIES = 10_000


def tried(function, arguments):
    """What came out of each call, None where it was refused; by two threads at once."""

    def one(argument):
        try:
            return function(argument)
        except InUse:
            return None

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(one, arguments, chunksize=1))


def test_two_threads_on_one_solver_get_right_answers_or_none():
    given = list(problems(7, 50))
    expected = [Solver().solve(h).x for h in given]
    solver = Solver()
    order = [k % 50 for k in range(TRIES)]
    found = tried(lambda k: solver.solve(given[k]).x, order)
    for k, x in zip(order, found, strict=True):
        assert x is None or np.abs(x - expected[k]).max() <= 1e-7


@pytest.mark.parametrize("shared", ["controller", "robot"])
def test_two_threads_on_one_robot_get_right_answers_or_none(shared):
    original = controller_of("panda")
    other = original if shared == "controller" else Controller(original.robot, original.stack, dt=0.01)
    ticks = list(states(original.robot, 8))
    expected = [copy.deepcopy(original)(*tick).v for tick in ticks]
    order = [(k % TICKS, (original, other)[k % 2]) for k in range(500)]
    found = tried(lambda pair: pair[1](*ticks[pair[0]]).v, order)
    for (k, _), v in zip(order, found, strict=True):
        assert v is None or np.abs(v - expected[k]).max() <= 1e-6


def test_a_second_thread_inside_is_told():
    """Whatever the timing: while one is inside, the next one is refused, and after it let in again."""
    solver, batch = Solver(), BatchSolver(threads=1)
    damped_solver, controller = Solver(damping={1: 0.1}), controller_of("panda")
    h = next(problems(9, 1))
    calls = {
        solver._guard: lambda: solver.solve(h),
        batch._guard: lambda: batch.solve(Batch(h, 2)),
        damped_solver._guard: lambda: damped_solver.solve(h),
        controller._states.guard: lambda: controller(controller.robot.home, np.zeros(7)),
    }
    for guard, call in calls.items():
        call()
        guard.take()
        with pytest.raises(InUse, match=r"is at work for another thread; give each its own, as by copy\.deepcopy"):
            call()
        guard.give(None)
        call()


def in_child(work):
    """Run it in a forked child; True if it came back with True, in time."""
    context = multiprocessing.get_context("fork")
    queue = context.SimpleQueue()
    child = context.Process(target=lambda: queue.put(bool(work())), daemon=True)
    child.start()
    child.join(60)
    alive = child.is_alive()
    if alive:
        child.kill()
    return not alive and child.exitcode == 0 and queue.get()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork:DeprecationWarning")
def test_forked_children_solve_and_do_not_hang():
    batch, solver, single = Batch.of(problems(10, 40)), BatchSolver(threads=2), Solver()
    h = next(problems(11, 1))
    expected, alone = solver.solve(batch).x, single.solve(h).x

    def again():
        return np.allclose(solver.solve(batch).x, expected, atol=1e-9) and np.allclose(single.solve(h).x, alone)

    assert in_child(again)
    for guard in solver._guard, single._guard:  # forked while a thread of the parent was inside
        guard.take()
    assert in_child(again)
    for guard in solver._guard, single._guard:
        guard.give(None)
    assert again()


@given(seed=st.integers(0, 2**32 - 1))
def test_a_copy_of_a_copy_of_any_problem(seed):
    rng = np.random.default_rng(seed)
    given_problems = list(problems(seed, 3, n=int(rng.integers(1, 9))))
    solver = Solver()
    solver.solve(given_problems[0])
    twin = copy.deepcopy(pickle.loads(pickle.dumps(copy.copy(solver))))
    for h in given_problems:
        x = twin.solve(h).x
        np.testing.assert_allclose(twin.solve(copy.deepcopy(h)).x, x, rtol=0, atol=1e-11 * np.linalg.norm(x))
        assert twin.solve(h).certify().ok
