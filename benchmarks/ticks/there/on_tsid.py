"""TSID: accelerations of a QP with two levels, rows above weighted tasks."""

import numpy as np
import pinocchio as pin
import tsid
from joints import Joints


class Library(Joints):
    r"""``InverseDynamicsFormulationAccForce`` from rest, of robots whose base is fixed.

    A step at velocity order is what one tick of the acceleration :math:`a` does to a robot at rest, whose tasks have no
    drift: :math:`v = a\,\Delta t`. At gains of :math:`1/\Delta t^2` its tasks ask for the whole way to the target of
    that tick. Its limits are those of velocity, which a joint's range narrows.

    Options
    -------
    first : int
        The level of the tasks of the first one: 1 to weigh them as the others, 0 for rows.
    """

    def __init__(self, scene, given, first=1):
        self.robot = tsid.RobotWrapper(scene["urdf"], [], False)
        model = self.robot.model()
        self.dt = scene["dt"]
        self.columns = [model.joints[model.getJointId(name)].idx_v for name in scene["joints"]]
        self.q, self.postures = (self.configured(given[name]) for name in ("q", "posture"))
        self.low, self.high, self.speed = (self.configured(given[name]) for name in ("low", "high", "speed"))
        self.formulation = tsid.InverseDynamicsFormulationAccForce("tsid", self.robot, False)
        self.rest = np.zeros(model.nv)
        self.formulation.computeProblemData(0.0, self.q[0], self.rest)
        self.targets = []
        for number, goal in enumerate(scene["goals"]):
            level = first if goal["level"] == 0 else 1
            self.add(goal, f"task {number}", level, given)
        if first == 0 and all(goal["level"] == 0 for goal in scene["goals"]):
            self.add_rest()
        self.bounds = tsid.TaskJointBounds("bounds", self.robot, self.dt)
        self.formulation.addMotionTask(self.bounds, 1.0, 0, 0.0)
        self.solver = tsid.SolverHQuadProgFast("solver")
        self.solver.resize(self.formulation.nVar, self.formulation.nEq, self.formulation.nIn)

    def add(self, goal, name, level, given):
        """Declare a task, and its samples tick by tick."""
        gain, frame = 1.0 / self.dt**2, goal["frame"]
        if goal["what"] == "posture":
            task = tsid.TaskJointPosture(name, self.robot)
            task.setKp(np.full(self.robot.nv, gain))
            task.setKd(np.zeros(self.robot.nv))
            values = self.postures
        else:
            task = tsid.TaskSE3Equality(name, self.robot, frame)
            asked = {"position": [1, 1, 1, 0, 0, 0], "orientation": [0, 0, 0, 1, 1, 1], "pose": [1] * 6}
            task.setMask(np.array(asked[goal["what"]], dtype=float))
            task.useLocalFrame(False)
            task.setKp(np.full(6, gain))
            task.setKd(np.zeros(6))
            values = self.poses(goal, given)
        samples = [self.sample(value) for value in values]
        task.setReference(samples[0])
        self.formulation.addMotionTask(task, goal["cost"] ** 2, level, 0.0)
        self.targets.append((task, samples))

    def add_rest(self):
        """Weigh a robot that stays where it is: with nothing weighed, the solver did not come back from a state."""
        self.rested = task = tsid.TaskJointPosture("rest", self.robot)  # kept here: TSID does not
        task.setKp(np.zeros(self.robot.nv))
        task.setKd(np.zeros(self.robot.nv))
        task.setReference(self.sample(self.q[0]))
        self.formulation.addMotionTask(task, 1.0, 1, 0.0)

    def poses(self, goal, given):
        """Targets. What moves the position is the logarithm of a pose: of a position alone, at the frame's own turn."""
        frame = goal["frame"]
        rotations = given[f"turned {frame}" if goal["what"] == "position" else f"rotation {frame}"]
        return [pin.SE3(R, p) for R, p in zip(rotations, given[f"position {frame}"], strict=True)]

    def sample(self, value):
        """A target that stands still, as TSID has it."""
        if isinstance(value, pin.SE3):
            sample = tsid.TrajectorySample(12, 6)
            sample.value(tsid.SE3ToVector(value))
            sample.derivative(np.zeros(6))
            sample.second_derivative(np.zeros(6))
            return sample
        sample = tsid.TrajectorySample(self.robot.nv)
        sample.value(value)
        return sample

    def prepare(self, k):
        """The limits, which are those of one tick."""
        low, high = (self.low - self.q[k]) / self.dt, (self.high - self.q[k]) / self.dt
        self.bounds.setVelocityBounds(np.maximum(low, -self.speed), np.minimum(high, self.speed))

    def step(self, k):
        """One tick; None where it has no answer."""
        for task, samples in self.targets:
            task.setReference(samples[k])
        data = self.formulation.computeProblemData(0.0, self.q[k], self.rest)
        solution = self.solver.solve(data)
        if solution.status != 0:
            return None
        return self.dt**2 * self.formulation.getAccelerations(solution)
