"""The methods of other libraries in ``python -m benchmarks ik``: their step, repeated.

Pink, mink and OInK solve one weighted QP a step and leave the loop to their users. Here it is that of their examples: a
FrameTask of cost 1 [m] and 1 [rad], the limit of the configuration, and q integrated by the velocity; DAQP below Pink
and mink, where OInK has a ProxQP of its own. What they leave open is set to what solved most of some hundred poses:
full steps (gain 1, dt 1), `lm_damping` 1e-3, of OInK 1e-2 (tried: 0 to 1), limits neared by half of what is left
(tried: 0.3, 0.5, 0.95, 1), and no PostureTask beside the pose, which pulls it out of its tolerance; a second row of two
of them has the posture of their examples, of cost 1e-3. What serves all targets is made before the clock runs, where
`solve_ik` makes everything anew.
"""

from __future__ import annotations

from abc import abstractmethod
from importlib import import_module
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np

from hqp.arrays import Array
from tasks.base.rotations import log
from tasks.ik.inverse_kinematics import CANDIDATES, FALL, PATIENCE

from .ik_ours import TOLERANCE, Method, Outcome, Target, beyond
from .ticks.urdf import bare, for_mujoco

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: See above.
LM_DAMPING, OINK_DAMPING, LIMIT_GAIN, POSTURE = 1e-3, 1e-2, 0.5, 1e-3


class Peer(Method):
    """A step repeated until the pose is reached; restarts, if any, follow the rule of ``solve_ik``."""

    @abstractmethod
    def aim(self, target: Target) -> None:
        """Take this target."""

    @abstractmethod
    def move(self, q: Array) -> None:
        """Be at q."""

    @abstractmethod
    def step(self) -> Array:
        """Take one step; the configuration after it."""

    def error(self, target: Target) -> tuple[float, float]:
        """Distance [m] and angle [rad] to the target."""
        position, rotation = self.place()
        away, turn = target.position - position, log(target.rotation @ rotation.T)
        return float(np.sqrt(away @ away)), float(np.sqrt(turn @ turn))

    @abstractmethod
    def place(self) -> tuple[Array, Array]:
        """Where the tip is."""

    def solve(self, target: Target, budget: int) -> Outcome:
        self.aim(target)
        self.move(np.array(self.robot.home))
        rng, excess, least, idle = np.random.default_rng(target.seed), 0.0, np.inf, 0
        for steps in range(budget + 1):
            away, turn = self.error(target)
            if away <= TOLERANCE[0] and turn <= TOLERANCE[1]:
                return Outcome(True, steps, excess)
            if steps == budget:
                break
            idle = 0 if away + turn < FALL * least else idle + 1
            least = min(least, away + turn) if idle else away + turn
            if self.restarts and idle > PATIENCE:
                self.move(self._anew(target, rng))
                least, idle = np.inf, 0
            excess = max(excess, beyond(self.robot, self.step()))
        return Outcome(False, budget, excess)

    def _anew(self, target: Target, rng: np.random.Generator) -> Array:
        """The best of a few random configurations."""
        tries = []
        for _ in range(CANDIDATES):
            q = rng.uniform(*self.robot.position_limit)
            self.move(q)
            tries.append((sum(self.error(target)), q))
        return min(tries, key=lambda pair: pair[0])[1]


class Pink(Peer):
    """Pink's ``solve_ik``."""

    name, package, cost = "pink", "pink", 0.0

    def __init__(self, robot: PinocchioRobot, restarts: bool) -> None:
        super().__init__(robot, restarts)
        self._pink, self._pin = import_module("pink"), import_module("pinocchio")
        limits, tasks = import_module("pink.limits"), self._pink.tasks
        self._frame = tasks.FrameTask(robot.tip, position_cost=1.0, orientation_cost=1.0, lm_damping=LM_DAMPING)
        self._tasks = [self._frame]
        if self.cost:
            posture = tasks.PostureTask(cost=self.cost)
            posture.set_target(robot.home)
            self._tasks.append(posture)
        self._limits = [limits.ConfigurationLimit(robot.model, config_limit_gain=LIMIT_GAIN)]
        self._data = robot.model.createData()

    def aim(self, target: Target) -> None:
        self._frame.set_target(self._pin.SE3(target.rotation, target.position))

    def move(self, q: Array) -> None:
        self._at = self._pink.Configuration(self.robot.model, self._data, q)

    def step(self) -> Array:
        velocity = self._pink.solve_ik(
            self._at, self._tasks, 1.0, solver="daqp", limits=self._limits, safety_break=False
        )
        self._at.integrate_inplace(velocity, 1.0)
        return np.array(self._at.q)

    def place(self) -> tuple[Array, Array]:
        tip = self._at.get_transform_frame_to_world(self.robot.tip)
        return tip.translation, tip.rotation


class PinkPosture(Pink):
    """The same, with the posture of its examples."""

    name, cost = "pink, posture", POSTURE


class Mink(Peer):
    """mink's ``solve_ik``, on the same URDF in MuJoCo."""

    name, package, cost = "mink", "mink", 0.0

    def __init__(self, robot: PinocchioRobot, restarts: bool) -> None:
        super().__init__(robot, restarts)
        self._mink, model = import_module("mink"), mujoco_model(robot)
        self._frame = self._mink.FrameTask(
            robot.tip, "body", position_cost=1.0, orientation_cost=1.0, lm_damping=LM_DAMPING
        )
        self._tasks = [self._frame]
        if self.cost:
            posture = self._mink.PostureTask(model, cost=self.cost)
            posture.set_target(np.array(robot.home))
            self._tasks.append(posture)
        self._limits = [self._mink.ConfigurationLimit(model, gain=LIMIT_GAIN)]
        self._at = self._mink.Configuration(model)

    def aim(self, target: Target) -> None:
        turn = self._mink.SO3.from_matrix(target.rotation)
        self._frame.set_target(self._mink.SE3.from_rotation_and_translation(turn, target.position))

    def move(self, q: Array) -> None:
        self._at.update(q)

    def step(self) -> Array:
        velocity = self._mink.solve_ik(self._at, self._tasks, 1.0, solver="daqp", limits=self._limits)
        self._at.integrate_inplace(velocity, 1.0)
        return np.array(self._at.q)

    def place(self) -> tuple[Array, Array]:
        tip = self._at.get_transform_frame_to_world(self.robot.tip, "body")
        return tip.translation(), tip.rotation().as_matrix()


class MinkPosture(Mink):
    """The same, with the posture of its examples."""

    name, cost = "mink, posture", POSTURE


class Oink(Peer):
    """roboplan's ``Oink.solveIk``."""

    name, package = "oink", "roboplan"

    def __init__(self, robot: PinocchioRobot, restarts: bool) -> None:
        super().__init__(robot, restarts)
        core, self._oink = import_module("roboplan.core"), import_module("roboplan.optimal_ik")
        description = core.loadUrdfSceneDescriptionFromXml(urdf(robot))
        scene = core.Scene(robot.name, description)
        self._solver = self._oink.Oink(scene)
        options = self._oink.FrameTaskOptions(1.0, 1.0, 1.0, lm_damping=OINK_DAMPING)
        start = core.CartesianConfiguration("", robot.tip, np.eye(4, order="F"))
        self._frame = self._oink.FrameTask(self._solver, scene, start, options)
        self._limits = [self._oink.PositionLimit(self._solver, gain=LIMIT_GAIN)]
        self._step, self._pin = np.zeros(robot.nv), import_module("pinocchio")
        self._model, self._data = robot.model, robot.model.createData()
        self._tip = robot.model.getFrameId(robot.tip)

    def aim(self, target: Target) -> None:
        pose = np.eye(4, order="F")
        pose[:3, :3], pose[:3, 3] = target.rotation, target.position
        self._frame.setTargetFrameTransform(pose)

    def move(self, q: Array) -> None:
        self._at = np.array(q)
        self._pin.forwardKinematics(self._model, self._data, self._at)
        self._pin.updateFramePlacement(self._model, self._data, self._tip)

    def step(self) -> Array:
        self._solver.solveIk(self._at, [self._frame], self._limits, [], self._step)
        self.move(self._at + self._step)
        return self._at

    def place(self) -> tuple[Array, Array]:
        tip = self._data.oMf[self._tip]
        return tip.translation, tip.rotation


def urdf(robot: PinocchioRobot) -> str:
    """The URDF of a robot of the library as text, without geometry; the joints that the robot holds are fixed."""
    return ET.tostring(held(robot), encoding="unicode")


def held(robot: PinocchioRobot) -> ET.Element:
    """The same, parsed."""
    root = bare(robot.name, ())
    moving = [joint.get("name", "") for joint in root.findall("joint") if joint.get("type") != "fixed"]
    return bare(robot.name, set(moving) - set(robot.joint_names))


def mujoco_model(robot: PinocchioRobot) -> Any:
    """The same in MuJoCo."""
    return import_module("mujoco").MjModel.from_xml_string(for_mujoco(held(robot), floating=False))
