"""The range of a joint is its soft range, where its safety controller has one, as far as that lies in its limit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_files import joint, write

from hqp import InvalidInput
from tasks import load_robot

pytestmark = pytest.mark.usefixtures("nothing_told")


def arm(folder: Path, safety: str, **options: object) -> Path:
    """One joint with a safety controller of these attributes."""
    text = joint("j", "link0", "link1", **options)  # type: ignore[arg-type]
    return write(folder, text.replace("</joint>", f"<safety_controller {safety}/></joint>"), links=2)


def soft(low: object, high: object) -> str:
    return f'soft_lower_limit="{low}" soft_upper_limit="{high}" k_position="15" k_velocity="10"'


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_range_is_where_both_ranges_are(tmp_path: Path, kind: str) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        hard, own = np.sort(rng.uniform(-2.0, 2.0, (2, 2)))
        both = max(hard[0], own[0]), min(hard[1], own[1])
        path = arm(tmp_path, soft(*own), kind=kind, lower=hard[0], upper=hard[1])
        if both[0] > both[1]:
            with pytest.raises(InvalidInput, match=r"joint 'j': the soft range is outside the range"):
                load_robot(path)
            continue
        limit = load_robot(path).position_limit
        assert limit is not None
        assert tuple(limit[:, 0]) == both


@pytest.mark.parametrize(
    ("safety", "options", "expected"),
    [
        ('k_velocity="10"', {}, (-1.0, 1.0)),
        (soft(0, 0.0), {}, (-1.0, 1.0)),
        ('soft_lower_limit="-0.5" k_velocity="1"', {}, (-0.5, 1.0)),
        ('soft_upper_limit="0.25" k_velocity="1"', {}, (-1.0, 0.25)),
        (soft(-0.5, 0.25), {"lower": 0.0, "upper": 0.0}, (-0.5, 0.25)),
        (soft(-1e-3, 1.0 / 3.0), {}, (-1e-3, 1.0 / 3.0)),
        (soft(-7, 7), {}, (-1.0, 1.0)),
    ],
)
def test_what_is_not_given_is_no_bound(tmp_path: Path, safety: str, options: dict, expected: tuple) -> None:
    limit = load_robot(arm(tmp_path, safety, **options)).position_limit
    assert limit is not None
    assert tuple(limit[:, 0]) == expected


def test_a_continuous_joint_has_no_range_to_narrow(tmp_path: Path) -> None:
    assert load_robot(arm(tmp_path, soft(-0.5, 0.5), kind="continuous")).position_limit is None


@pytest.mark.parametrize(
    ("safety", "said"),
    [
        (soft(0.5, -0.5), "the soft range 0.5 .. -0.5 is empty"),
        (soft("nan", 0.5), "soft_lower_limit = 'nan' must be a finite number"),
        (soft(-0.5, "1_0"), "soft_upper_limit = '1_0' must be a finite number"),
        (soft(-0.5, "much"), "soft_upper_limit = 'much' must be a finite number"),
        (soft(-0.5, ""), "soft_upper_limit = '' must be a finite number"),
        (soft(-0.5, 0.5).replace("upper", "uper"), "'soft_uper_limit' of <safety_controller> .*'soft_upper_limit'"),
        (soft(-0.5, 0.5) + "/><safety_controller " + soft(-0.5, 0.5), "has several <safety_controller>"),
        (soft(1.5, 2.0), "the soft range is outside the range -1 .. 1"),
    ],
)
def test_what_is_no_soft_range_is_refused(tmp_path: Path, safety: str, said: str) -> None:
    with pytest.raises(InvalidInput, match=said):
        load_robot(arm(tmp_path, safety))


def test_a_follower_keeps_its_leader_inside_its_soft_range(tmp_path: Path) -> None:
    lead = joint("lead", "link0", "link1")
    own = joint("own", "link1", "link2", mimic=("lead", 2.0, 0.1))
    path = write(tmp_path, lead, own.replace("</joint>", f"<safety_controller {soft(-0.9, 0.5)}/></joint>"), links=3)
    limit = load_robot(path, mimic="follow").position_limit
    assert limit is not None
    np.testing.assert_allclose(limit[:, 0], [-0.5, 0.2], atol=1e-12)


def test_soft_ranges_of_a_mobile_manipulator() -> None:
    robot = load_robot("tiago", mimic="free")
    assert robot.position_limit is not None
    low, high = robot.position_limit[:, robot.joint_names.index("arm_1_joint")]
    assert (low, high) == (0.07, 2.67889357189)  # the limits are 0.07 rad farther out, on both sides
