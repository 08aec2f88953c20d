"""Drake: a QP that weighs poses and projects a posture, or one that slows a pose down and keeps its direction."""

import numpy as np
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

#: What the poses weigh over the posture: what its documentation advises.
WEIGHT = 100.0


class Library:
    """``DifferentialInverseKinematicsSystem``, or ``DoDifferentialInverseKinematics``, of one frame.

    Options
    -------
    scaled : bool
        Whether it is the second, the older one, which keeps the direction of the pose.
    margins : bool
        Whether the first slows joints down from 0.1 rad before their ranges end, as it does by default; else no earlier
        than a joint reaches that end within one tick at the speed of the fastest.
    """

    def __init__(self, scene, given):
        builder = RobotDiagramBuilder(time_step=0.0)
        builder.parser().AddModels(scene["urdf"])
        plant = builder.plant()
        if scene["root"] != "world":  # which is welded already
            plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(scene["root"]))
        plant.Finalize()
        self.plant, self.dt = plant, scene["dt"]
        self.columns = [plant.GetJointByName(name).velocity_start() for name in scene["joints"]]
        self.q, self.postures = (self.configured(given[name]) for name in ("q", "posture"))
        low, high, speed = (self.configured(given[name][None])[0] for name in ("low", "high", "speed"))
        goals = scene["goals"]
        (self.frame,) = {goal["frame"] for goal in goals if goal["what"] != "posture"}
        asked = {goal["what"] for goal in goals}
        self.axes = np.repeat([bool(asked & {"orientation", "pose"}), bool(asked & {"position", "pose"})], 3)
        self.centred = "posture" in asked
        places = zip(given[f"rotation {self.frame}"], given[f"position {self.frame}"], strict=True)
        self.poses = [RigidTransform(RotationMatrix(R), p) for R, p in places]
        if scene["options"].get("scaled", False):
            self.diagram, self.step = builder.Build(), self.scaled
            self.context = plant.GetMyContextFromRoot(self.diagram.CreateDefaultContext())
            self.parameters = self.scaling(low, high, speed)
        else:
            limits = JointLimits(low, high, -speed, speed, np.full_like(speed, -np.inf), np.full_like(speed, np.inf))
            self.system, self.step = self.weighing(builder, limits, scene["options"].get("margins", True)), self.weighed
            self.context = self.system.CreateDefaultContext()

    def configured(self, rows):
        """Numbers of the joints in the order of Drake."""
        ordered = np.zeros_like(rows)
        ordered[:, self.columns] = rows
        return ordered

    def weighing(self, builder, limits, margins):
        """The system, of least squares, a posture in their null space, and limits."""
        model = self.plant.GetBodyByName(self.frame).model_instance()
        name = self.plant.GetBodyByName(self.frame).scoped_name().get_full()
        checker = SceneGraphCollisionChecker(
            model=builder.Build(), robot_model_instances=[model], edge_step_size=0.1
        )
        kind, masks = DifferentialInverseKinematicsSystem, {name: self.axes.astype(float)}
        recipe = kind.Recipe()
        recipe.AddIngredient(kind.LeastSquaresCost(self.filled(kind.LeastSquaresCost.Config(), masks, WEIGHT)))
        if self.centred:
            recipe.AddIngredient(kind.JointCenteringCost(self.filled(kind.JointCenteringCost.Config(), masks)))
        margin = kind.JointVelocityLimitConstraint.Config()
        if not margins:
            margin.min_margin, margin.influence_margin = 0.0, self.dt * limits.velocity_upper().max()
        recipe.AddIngredient(kind.JointVelocityLimitConstraint(margin, limits))
        endless = SpatialVelocity(w=np.full(3, np.inf), v=np.full(3, np.inf))
        self.checker, self.name = checker, name
        every = DofMask(self.plant.num_velocities(), True)
        return kind(recipe, "world", checker, every, self.dt, 1.0, endless)

    def filled(self, config, masks, weight=None):
        """A configuration with the axes that count."""
        config.cartesian_axis_masks = masks
        if weight is None:
            config.posture_gain = 1.0 / self.dt
        else:
            config.cartesian_qp_weight = weight
        return config

    def weighed(self, k):
        """One tick of the system; raises RuntimeError where it has no answer."""
        system, context, poses = self.system, self.context, BusValue()
        poses.Set(self.name, Value(self.poses[k]))
        system.get_input_port_position().FixValue(context, self.q[k])
        system.get_input_port_nominal_posture().FixValue(context, self.postures[k])
        system.get_input_port_desired_cartesian_poses().FixValue(context, Value(poses))
        return self.dt * system.get_output_port_commanded_velocity().Eval(context)

    def scaling(self, low, high, speed):
        """What the older function is told."""
        parameters = DifferentialInverseKinematicsParameters(len(low), len(low))
        parameters.set_time_step(self.dt)
        parameters.set_joint_position_limits((low, high))
        parameters.set_joint_velocity_limits((-speed, speed))
        parameters.set_end_effector_velocity_flag(self.axes)
        if self.centred:
            parameters.set_joint_centering_gain(np.eye(len(low)) / self.dt)
        return parameters

    def scaled(self, k):
        """One tick of the function; None where it has no answer."""
        self.plant.SetPositions(self.context, self.q[k])
        self.parameters.set_nominal_joint_position(self.postures[k])
        frame = self.plant.GetFrameByName(self.frame)
        found = DoDifferentialInverseKinematics(self.plant, self.context, self.poses[k], frame, self.parameters)
        return None if found.joint_velocities is None else self.dt * found.joint_velocities

    def prepare(self, k):
        """Nothing is left to do."""

    def ordered(self, step):
        """In the order of the motion."""
        return [*step[self.columns]]

    def split(self, k):
        """Its parts are not told."""
        return [None] * 3
