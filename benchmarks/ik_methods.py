"""What solves for a pose in ``python -m benchmarks ik``: ours, and the step of a peer, repeated.

Pink and Mink solve one weighted QP a step and leave the loop to their users. Here it is that of their examples: a
FrameTask of cost 1 [m] and 1 [rad], the limit of the configuration, DAQP below, and q integrated by the velocity. What
they leave open is set to what solved most of some hundred poses: full steps (gain 1, dt 1), `lm_damping` 1e-3 (tried: 0
to 1), limits neared by half of what is left (tried: 0.3, 0.5, 0.95, 1), and no PostureTask beside the pose, which pulls
it out of its tolerance; a second row has the posture of their examples, of cost 1e-3. What serves all targets is made
before the clock runs, where `solve_ik` makes everything anew.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from hqp.arrays import Array
from tasks import OrientationTask, PoseTask, PositionTask, PostureTask, Stack, solve_ik
from tasks.base.rotations import log
from tasks.ik.inverse_kinematics import CANDIDATES, FALL, PATIENCE
from tasks.robots.library import ROBOTS, data_folder

if TYPE_CHECKING:
    from tasks.robots.pinocchio import PinocchioRobot

#: When a pose counts as reached [m], [rad].
TOLERANCE = (1e-4, 1e-3)
#: Of the peers; see above.
LM_DAMPING, LIMIT_GAIN, POSTURE = 1e-3, 0.5, 1e-3


@dataclass(frozen=True)
class Target:
    """A pose of the tip, and the number of its draw."""

    position: Array
    rotation: Array
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What a method made of a target: whether it was reached, in how many steps, the largest excess over a limit."""

    reached: bool
    steps: int
    beyond: float


class Method(ABC):
    """A name, and a way to a pose from the home configuration.

    Parameters
    ----------
    robot : PinocchioRobot
    restarts : bool
        Whether to begin anew from random configurations where it is stuck.
    """

    name: str
    package: str = "numpy"

    def __init__(self, robot: PinocchioRobot, restarts: bool) -> None:
        self.robot, self.restarts = robot, restarts

    @abstractmethod
    def solve(self, target: Target, budget: int) -> Outcome:
        """Go to the pose in at most so many steps."""


class Native(Method):
    """``solve_ik``, the making of the tasks and of the hierarchy included; position and orientation on one level."""

    name = "native"

    def stack(self, target: Target) -> Stack:
        """What is wanted, in order of priority."""
        return Stack(PoseTask(target.position, target.rotation, gain=1.0))

    def solve(self, target: Target, budget: int) -> Outcome:
        found = solve_ik(
            self.robot,
            self.stack(target),
            tolerance=TOLERANCE,
            iterations=budget,
            restarts=self.restarts,
            settle=False,
            seed=target.seed,
        )
        return Outcome(found.reached, found.iterations, beyond(self.robot, found.q))


class NativeStrict(Native):
    """Position above orientation."""

    name = "native, strict"

    def stack(self, target: Target) -> Stack:
        return PositionTask(target.position, gain=1.0) >> OrientationTask(target.rotation, gain=1.0)


class NativePosture(NativeStrict):
    """The same, with a posture as the third level."""

    name = "native, posture"

    def stack(self, target: Target) -> Stack:
        return super().stack(target) >> PostureTask(self.robot.home, gain=1.0)


class Peer(Method):
    """A step repeated until the pose is reached, begun anew by the rule of ``solve_ik`` if at all."""

    @abstractmethod
    def aim(self, target: Target) -> None:
        """Take this target."""

    @abstractmethod
    def move(self, q: Array) -> None:
        """Be at q."""

    @abstractmethod
    def step(self) -> Array:
        """One step; where it led."""

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
    """Mink's ``solve_ik``, on the same URDF in MuJoCo."""

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


METHODS: tuple[type[Method], ...] = (Native, NativeStrict, NativePosture, Pink, PinkPosture, Mink, MinkPosture)


def missing(method: type[Method]) -> str:
    """Why a method cannot be measured here; empty if it can."""
    needed = [method.package, *(["mujoco"] if method.package == "mink" else [])]
    gone = [name for name in [*needed, "daqp"] if find_spec(name) is None] if issubclass(method, Peer) else []
    why = f"{method.name}: left out, {', '.join(gone)} is not installed: pip install 'hqp[peers,solvers]'"
    return why if gone else ""


def beyond(robot: PinocchioRobot, q: Array) -> float:
    """By how much a joint is outside its range at most [rad]; 0 inside."""
    assert robot.position_limit is not None
    low, high = robot.position_limit
    return max(0.0, float(np.maximum(low - q, q - high).max()))


def mujoco_model(robot: PinocchioRobot) -> Any:
    """The URDF of a robot in MuJoCo, without what is seen or touched; the joints that the robot holds are fixed."""
    text = (data_folder() / ROBOTS[robot.name].file).read_text()
    text = re.sub(r"<(visual|collision|mujoco|transmission|gazebo)\b.*?</\1>", "", text, flags=re.DOTALL)
    for joint in re.findall(r'<joint name="([^"]+)" type="(?:revolute|prismatic)"', text):
        if joint not in robot.joint_names:
            text = re.sub(rf'(<joint name="{re.escape(joint)}" type=)"\w+"', r'\1"fixed"', text)
    # Frames stay bodies of their own, and what has no mass is no error.
    options = 'fusestatic="false" balanceinertia="true" boundmass="1e-6" boundinertia="1e-9"'
    text = text.replace("</robot>", f"<mujoco><compiler {options}/></mujoco></robot>")
    return import_module("mujoco").MjModel.from_xml_string(text)
