"""The same robot in URDF and in MJCF has the same frames, Jacobians, limits, masses and torques."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

pytest.importorskip("pinocchio")
mujoco = pytest.importorskip("mujoco")

from tasks import load_robot  # noqa: E402

#: MuJoCo reads URDF too; it is to keep fixed links, and to take inertias as they are.
COMPILER = '<mujoco><compiler fusestatic="false" balanceinertia="false"/></mujoco>'


def numbers(*values: float) -> str:
    return " ".join(f"{value:.17g}" for value in values)


def link(name: str, rng: np.random.Generator) -> str:
    """A link whose inertia some body has, its principal axes turned."""
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    squares = rng.uniform(0.01, 0.1, 3)
    J = R @ np.diag(squares.sum() - squares) @ R.T
    pairs = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), J[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)], strict=True)
    entries = " ".join(f'{key}="{value:.17g}"' for key, value in pairs)
    return (
        f'<link name="{name}"><inertial><origin {place(rng)}/><mass value="{rng.uniform(0.1, 3.0):.17g}"/>'
        f"<inertia {entries}/></inertial></link>"
    )


def place(rng: np.random.Generator) -> str:
    return f'xyz="{numbers(*rng.uniform(-0.3, 0.3, 3))}" rpy="{numbers(*rng.uniform(-3.0, 3.0, 3))}"'


def joint(i: int, kind: str, rng: np.random.Generator) -> str:
    """A joint from link i to an earlier one; its axis may have any length."""
    ends = f'<parent link="link{rng.integers(i)}"/><child link="link{i}"/><origin {place(rng)}/>'
    axis = rng.normal(size=3) if rng.random() < 0.5 else rng.choice([-1.0, 2.0]) * np.eye(3)[rng.integers(3)]
    low, high = sorted(rng.uniform(-2.0, 2.0, 2))
    effort = rng.uniform(1.0, 30.0)
    limit = f'<limit lower="{low:.17g}" upper="{high:.17g}" velocity="2" effort="{effort:.17g}"/>'
    moving = "" if kind == "fixed" else f'<axis xyz="{numbers(*axis)}"/>{limit}'
    return f'<joint name="joint{i}" type="{kind}">{ends}{moving}</joint>'


@pytest.mark.parametrize("seed", range(12))
def test_a_robot_is_the_same_in_both_languages(tmp_path, seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 7))
    kinds = ["revolute", *rng.choice(["revolute", "prismatic", "fixed"], count - 1, p=[0.6, 0.2, 0.2])]
    joints = "".join(joint(i, kind, rng) for i, kind in enumerate(kinds, 1))
    text = f'<robot name="r">{COMPILER}{"".join(link(f"link{i}", rng) for i in range(count + 1))}{joints}</robot>'
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    one, other = load_robot(path), load_robot(mujoco.MjModel.from_xml_string(text))

    assert sorted(one.joint_names) == sorted(other.joint_names)
    order = [one.joint_names.index(name) for name in other.joint_names]
    assert [one.joint_units[i] for i in order] == list(other.joint_units)
    assert_allclose(one.position_limit[:, order], other.position_limit, rtol=0, atol=1e-12)
    assert_allclose(one.torque_limit[order], other.torque_limit, rtol=1e-12)
    q, v = rng.uniform(-2.0, 2.0, one.nq), rng.normal(size=one.nv)
    states = one.at(q, v), other.at(q[order], v[order])
    for name in (f"link{i}" for i in range(1, count + 1)):
        mine, theirs = (state.frame(name) for state in states)
        assert_allclose(mine.position, theirs.position, atol=1e-9)
        assert_allclose(mine.rotation, theirs.rotation, atol=1e-9)
        assert_allclose(mine.linear[:, order], theirs.linear, atol=1e-9)
        assert_allclose(mine.angular[:, order], theirs.angular, atol=1e-9)
    assert_allclose(one.mass_matrix(q)[np.ix_(order, order)], other.mass_matrix(q[order]), atol=1e-9)
    assert_allclose(one.bias(q, v)[order], other.bias(q[order], v[order]), atol=1e-8)
