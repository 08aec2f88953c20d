"""Drake: a QP that weighs poses and projects a posture, or one that slows a pose down and keeps its direction."""

import numpy as np
from joints import Joints
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DifferentialInverseKinematicsSystem,
    DoDifferentialInverseKinematics,
)
from pydrake.multibody.math import SpatialVelocity
from pydrake.planning import DofMask, JointLimits, RobotDiagramBuilder, SceneGraphCollisionChecker
from pydrake.systems.framework import BusValue

#: What a pose weighs over a posture: what its documentation advises.
WEIGHT = 100.0


class OneFrame(Joints):
    """A robot, one of whose frames has tasks.

    Attributes
    ----------
    axes : array, shape (6,)
        Those that count, of the turn and of the position; nobody can weigh them.
    centred : bool
        Whether there is a posture.
    """

    def __init__(self, scene, given):
        self.builder, self.dt = RobotDiagramBuilder(time_step=0.0), scene["dt"]
        self.builder.parser().AddModels(scene["urdf"])
        self.plant = plant = self.builder.plant()
        if scene["root"] != "world":  # which is welded already
            plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(scene["root"]))
        plant.Finalize()
        self.columns = [plant.GetJointByName(name).velocity_start() for name in scene["joints"]]
        self.q, self.postures = (self.configured(given[name]) for name in ("q", "posture"))
        self.low, self.high, self.speed = (self.configured(given[name]) for name in ("low", "high", "speed"))
        asked = {goal["what"]: goal["frame"] for goal in scene["goals"]}
        self.centred = asked.pop("posture", None) is not None
        (frame,) = set(asked.values())
        self.body = plant.GetBodyByName(frame)
        self.axes = np.repeat([not asked.keys().isdisjoint({"pose", what}) for what in ("orientation", "position")], 3)
        places = zip(given[f"rotation {frame}"], given[f"position {frame}"], strict=True)
        self.poses = [RigidTransform(RotationMatrix(R), p) for R, p in places]


class Weighed(OneFrame):
    """``DifferentialInverseKinematicsSystem``.

    Options
    -------
    margins : bool
        Whether joints slow down from 0.1 rad before their range ends and stop short of it, as they do by default; else
        they do so from where the fastest joint would reach it within one tick.
    """

    def __init__(self, scene, given, margins=True):
        super().__init__(scene, given)
        kind, self.name = DifferentialInverseKinematicsSystem, self.body.scoped_name().get_full()
        recipe, masks = kind.Recipe(), {self.name: self.axes.astype(float)}
        pose = kind.LeastSquaresCost.Config(cartesian_qp_weight=WEIGHT, cartesian_axis_masks=masks)
        recipe.AddIngredient(kind.LeastSquaresCost(pose))
        if self.centred:
            centre = kind.JointCenteringCost.Config(posture_gain=1.0 / self.dt, cartesian_axis_masks=masks)
            recipe.AddIngredient(kind.JointCenteringCost(centre))
        margin = kind.JointVelocityLimitConstraint.Config()
        if not margins:
            margin.min_margin, margin.influence_margin = 0.0, self.dt * self.speed.max()
        endless = np.full(len(self.speed), np.inf)
        limits = JointLimits(self.low, self.high, -self.speed, self.speed, -endless, endless)
        recipe.AddIngredient(kind.JointVelocityLimitConstraint(margin, limits))
        robot = [self.body.model_instance()]
        checker = SceneGraphCollisionChecker(
            model=self.builder.Build(), robot_model_instances=robot, edge_step_size=0.1
        )
        every, free = DofMask(len(self.speed), True), SpatialVelocity(np.full(3, np.inf), np.full(3, np.inf))
        self.system = kind(recipe, "world", checker, every, self.dt, 1.0, free)
        self.context = self.system.CreateDefaultContext()

    def step(self, k):
        """One tick; raises RuntimeError where it has no answer."""
        system, context, poses = self.system, self.context, BusValue()
        poses.Set(self.name, Value(self.poses[k]))
        system.get_input_port_position().FixValue(context, self.q[k])
        system.get_input_port_nominal_posture().FixValue(context, self.postures[k])
        system.get_input_port_desired_cartesian_poses().FixValue(context, Value(poses))
        return self.dt * system.get_output_port_commanded_velocity().Eval(context)


class Scaled(OneFrame):
    """``DoDifferentialInverseKinematics``, the older of the two."""

    def __init__(self, scene, given):
        super().__init__(scene, given)
        diagram = self.builder.Build()
        self.root = diagram.CreateDefaultContext()
        self.context = self.plant.GetMyContextFromRoot(self.root)
        self.parameters = parameters = DifferentialInverseKinematicsParameters(len(self.low), len(self.low))
        parameters.set_time_step(self.dt)
        parameters.set_joint_position_limits((self.low, self.high))
        parameters.set_joint_velocity_limits((-self.speed, self.speed))
        parameters.set_end_effector_velocity_flag(self.axes)
        if self.centred:
            parameters.set_joint_centering_gain(np.eye(len(self.low)) / self.dt)
        self.diagram = diagram

    def step(self, k):
        """One tick; None where it has no answer."""
        self.plant.SetPositions(self.context, self.q[k])
        self.parameters.set_nominal_joint_position(self.postures[k])
        frame = self.body.body_frame()
        found = DoDifferentialInverseKinematics(self.plant, self.context, self.poses[k], frame, self.parameters)
        return None if found.joint_velocities is None else self.dt * found.joint_velocities


def Library(scene, given, scaled=False, **options):
    """The older function if scaled, else the system."""
    return Scaled(scene, given) if scaled else Weighed(scene, given, **options)
