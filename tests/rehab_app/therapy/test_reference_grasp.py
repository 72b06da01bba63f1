from __future__ import annotations

import numpy as np
import pytest

from rehab_app.grasp.hand import human_hand, robot_hand
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import find_posture
from rehab_app.grasp.spiral import GraspPath, spiral_path
from rehab_app.therapy.reference_grasp import reference_from_grasp
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand
from robot_iface.motion import QuinticPath, check_path
from robot_iface.safety import shipped_limits
from robot_iface.types import Limits
from sessions.errors import Refused
from sessions.records import JOINTS

PERSON = human_hand(average_hand())
ROBOT = robot_hand()
WORN, BARE = capabilities("exoskeleton"), capabilities("dlr-hit-ii")


@pytest.fixture(scope="module")
def human_way() -> GraspPath:
    return spiral_path(find_posture(PERSON, Cylinder(0.025)))


@pytest.fixture(scope="module")
def robot_way() -> GraspPath:
    return spiral_path(find_posture(ROBOT, Cylinder(0.025)))


def limits(name: str) -> Limits:
    device = capabilities(name)
    return shipped_limits(device.joint_names, device.q_min_rad, device.q_max_rad)


def test_a_grasp_is_played_there_and_back(human_way: GraspPath) -> None:
    built = reference_from_grasp(
        human_way, PERSON, patient_side="left", device=WORN, limits=limits("exoskeleton"), closing_s=4.0
    )
    path = built.path
    assert path.side == "left"
    assert path.t_s[-1] == pytest.approx(9.0)
    np.testing.assert_allclose(path.q_rad, path.q_rad[::-1], atol=1e-9)
    middle = path.q_rad[len(path.t_s) // 2]
    for column, name in enumerate(path.joint_names):
        goal = human_way.joints_rad[-1, JOINTS.index(name)]
        if np.deg2rad(8) < goal and name != "thumb_cmc_abduction":
            assert middle[column] == pytest.approx(goal, abs=np.deg2rad(0.2)), name
    spline = QuinticPath(path)
    ends = spline.sample(np.array([0.0, spline.duration_s]), 1)
    assert np.abs(ends).max() < np.deg2rad(0.1)
    assert "Limits clipped thumb_cmc_abduction by 5 deg at its upper end (40 deg)." in built.notes
    assert built.residual_m["index"] < 0.005


def test_it_keeps_the_limits_at_the_speed_asked_for(human_way: GraspPath) -> None:
    bounds = limits("exoskeleton")
    built = reference_from_grasp(
        human_way, PERSON, patient_side="right", device=WORN, limits=bounds, closing_s=1.0, speed=1.0
    )
    assert check_path(QuinticPath(built.path), bounds, 1.0, 0.001) is None
    assert built.notes[0].startswith("Slowed locally")


def test_the_robots_own_grasp_is_played_as_it_is(robot_way: GraspPath) -> None:
    built = reference_from_grasp(
        robot_way, ROBOT, patient_side="right", device=BARE, limits=limits("dlr-hit-ii")
    )
    middle = built.path.q_rad[len(built.path.t_s) // 2]
    for column, name in enumerate(BARE.joint_names):
        goal = robot_way.joints_rad[-1, JOINTS.index(name)]
        assert middle[column] == pytest.approx(goal, abs=np.deg2rad(1.2)), name
    assert max(built.residual_m.values()) < 0.003


def test_a_persons_grasp_is_retargeted_to_the_robot(human_way: GraspPath) -> None:
    built = reference_from_grasp(
        human_way, PERSON, patient_side="right", device=BARE, limits=limits("dlr-hit-ii")
    )
    assert built.path.joint_names == BARE.joint_names
    assert max(value for digit, value in built.residual_m.items() if digit != "thumb") < 0.001
    assert 0.03 < built.residual_m["thumb"] < 0.06
    assert any("thumb_cmc_abduction would be at 45 deg, its end is 15 deg" in note for note in built.notes)


def test_what_makes_no_sense_is_refused(robot_way: GraspPath, human_way: GraspPath) -> None:
    with pytest.raises(Refused, match="made for a person's hand"):
        reference_from_grasp(
            robot_way, ROBOT, patient_side="right", device=WORN, limits=limits("exoskeleton")
        )
    for change in ({"closing_s": 0.1}, {"hold_s": float("nan")}):
        with pytest.raises(Refused, match="time is"):
            reference_from_grasp(
                human_way,
                PERSON,
                patient_side="right",
                device=WORN,
                limits=limits("exoskeleton"),
                **change,
            )


def test_the_same_way_has_the_same_digest(human_way: GraspPath, robot_way: GraspPath) -> None:
    digests = {
        reference_from_grasp(
            one, hand, patient_side="right", device=BARE, limits=limits("dlr-hit-ii")
        ).path.take_digest
        for one, hand in ((human_way, PERSON), (human_way, PERSON), (robot_way, ROBOT))
    }
    assert len(digests) == 2
    assert all(len(digest) == 64 for digest in digests)
