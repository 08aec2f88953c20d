"""What rows have measured is what their parts measure: a record takes errors from the rows of the tick."""

from __future__ import annotations

import numpy as np
import pytest
from rows_of_all import parts

from hqp import InvalidInput
from tasks import (
    AtMost,
    CenterOfMassTask,
    Change,
    Controller,
    JointMotion,
    JointVelocityLimit,
    OrientationTask,
    PlanarArm,
    PositionTask,
    load_robot,
    simulate,
)

ARM = PlanarArm([0.5, 0.4, 0.3])
Q, V = np.array([0.3, 0.5, -0.4]), np.array([0.1, -0.2, 0.3])


def test_the_error_that_rows_have_is_that_of_the_part_at_every_order() -> None:
    known = set()
    for name, setting, part in parts():
        for order in "velocity", "acceleration":
            try:
                rows = (JointVelocityLimit(2.0) >> part).build(setting.robot, order, 0.01)
            except InvalidInput:  # it does not fit the robot or the order
                continue
            for q, v, t in setting.states:
                state = setting.robot.at(q, v)
                rows.fill(state, t)
                found = rows.places.error(part)
                if found is not None and hasattr(part, "error"):
                    known.add(type(part).__name__)
                    np.testing.assert_allclose(found, part.error(state, t), rtol=0.0, atol=1e-12, err_msg=name)
    assert {"PositionTask", "PoseTask", "PostureTask", "CenterOfMassTask", "JointMotion"} <= known


def test_an_error_that_is_cut_off_or_of_no_task_of_the_stack_is_not_known() -> None:
    tip, bound = PositionTask([0.6, 0.3], gain=2.0), AtMost(PositionTask([0.5], mask="x", gain=2.0))
    controller = Controller(ARM, JointVelocityLimit(3.0) >> bound >> tip >> JointMotion(OrientationTask(0.0, gain=1.0)))
    controller(Q)
    assert controller.error(OrientationTask(0.0, gain=1.0)) is None
    assert controller.error(bound) is None
    for cut, most in ("cap", 0.01), ("deceleration", 0.1):
        assert controller.error(tip) is not None
        setattr(tip, cut, most)
        controller(Q)
        assert controller.error(tip) is None
        setattr(tip, cut, None)
        controller(Q)


@pytest.mark.parametrize("cap", [None, 0.05])
@pytest.mark.parametrize("order", ["velocity", "acceleration"])
def test_a_record_has_the_errors_of_its_tasks_cut_off_or_not_and_after_a_change(order, cap) -> None:
    tip, turn = PositionTask([0.6, 0.3], gain=2.0, cap=cap), OrientationTask(0.4, gain=1.0)
    controller = Controller(ARM, JointVelocityLimit(3.0) >> tip >> turn, order=order, dt=0.02)
    record = simulate(controller, Q, V, duration=0.4, changes=[Change(0.2, turn >> tip, duration=0.1)])
    for task in tip, turn:
        told = [task.error(ARM.at(q, v), t) for q, v, t in zip(record.q, record.v, record.t, strict=True)]
        np.testing.assert_allclose(record.errors[task.name], told, rtol=0.0, atol=1e-12)


def test_a_task_is_measured_right_although_a_state_was_used_before() -> None:
    """Pinocchio allocates what a centre of mass needs by computing it somewhere else."""
    robot = load_robot("panda")
    state = robot.at(robot.home)
    state.frame(None)
    there = CenterOfMassTask([0.1, 0.0, 0.4], gain=1.0).error(state, 0.0)
    here = CenterOfMassTask([0.1, 0.0, 0.4], gain=1.0).error(robot.at(robot.home), 0.0)
    np.testing.assert_allclose(there, here, rtol=0.0, atol=1e-15)
