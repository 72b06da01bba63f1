from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rehab_app.errors import REFUSALS
from rehab_app.hand.subject import (
    geometry_from_json,
    geometry_to_json,
    on_side,
    subject_from_json,
    subject_to_json,
)
from robot_iface.kinematics import average_hand, forward


def test_a_subject_survives_its_file(person: Callable) -> None:
    subject = person("mocap13", "left", 0.2, 1)
    back = subject_from_json(subject_to_json(subject))
    assert back.geometry.side == "left"
    assert back.marker_names == subject.marker_names
    np.testing.assert_array_equal(back.marker_offset_m, subject.marker_offset_m)
    np.testing.assert_array_equal(back.geometry.bones_m, subject.geometry.bones_m)
    np.testing.assert_array_equal(
        geometry_from_json(subject_to_json(subject)).bases_m, subject.geometry.bases_m
    )


def test_a_geometry_survives_alone() -> None:
    geometry = average_hand(0.175)
    np.testing.assert_array_equal(geometry_from_json(geometry_to_json(geometry)).palm_m, geometry.palm_m)


def test_the_other_side_is_the_mirror_image() -> None:
    right = average_hand()
    joints = np.full(21, 0.3)
    mirrored = forward(on_side(right, "left"), joints).landmarks_m
    np.testing.assert_allclose(mirrored, forward(right, joints).landmarks_m * [1, -1, 1])


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"side": "right"}',
        "[" * 100000,
        geometry_to_json(average_hand()).replace("right", "upper"),
        geometry_to_json(average_hand()).replace('"bones_m": [[', '"bones_m": [[-'),
    ],
)
def test_text_that_is_no_hand_is_refused(text: str) -> None:
    with pytest.raises(REFUSALS):
        geometry_from_json(text)
