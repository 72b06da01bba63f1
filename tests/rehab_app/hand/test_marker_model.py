from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from rehab_app.hand.bundle import ShapePrior, shape_jacobian
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import PROTOCOLS, load_protocol
from rehab_app.hand.subject import average_subject
from robot_iface.kinematics import forward
from sessions.errors import Refused
from sessions.records import LANDMARKS, Side
from sessions.records.names import SIDES


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", PROTOCOLS)
def test_the_derivative_is_that_of_the_positions(name: str, side: Side, random_joints: Callable) -> None:
    protocol = load_protocol(name)
    model = MarkerModel(average_subject(protocol, side), protocol)
    joints = random_joints(3, np.random.default_rng(5))
    slopes = model.jacobian(joints)
    for joint in range(21):
        step = np.zeros(21)
        step[joint] = 1e-6
        numeric = (model.positions(joints + step) - model.positions(joints - step)) / 2e-6
        np.testing.assert_allclose(slopes[..., joint], numeric, atol=1e-8)


@pytest.mark.parametrize("side", SIDES)
def test_markers_without_offset_are_the_landmarks(side: Side, random_joints: Callable) -> None:
    protocol = load_protocol("thesis25")
    subject = average_subject(protocol, side)
    bare = MarkerModel(replace(subject, marker_offset_m=np.zeros((25, 3))), protocol)
    joints = random_joints(4, np.random.default_rng(6))
    rows = [LANDMARKS.index(name) for name in protocol.names]
    np.testing.assert_allclose(
        bare.positions(joints), forward(subject.geometry, joints).landmarks_m[:, rows], atol=1e-12
    )


def test_a_left_hand_is_the_mirror_image(random_joints: Callable) -> None:
    protocol = load_protocol("thesis25")
    right, left = (MarkerModel(average_subject(protocol, side), protocol) for side in ("right", "left"))
    joints = random_joints(4, np.random.default_rng(7))
    np.testing.assert_allclose(left.positions(joints), right.positions(joints) * [1, -1, 1], atol=1e-12)
    np.testing.assert_allclose(left.normals(joints), right.normals(joints) * [1, -1, 1], atol=1e-12)


def test_normals_point_out_of_the_back() -> None:
    protocol = load_protocol("thesis25")
    model = MarkerModel(average_subject(protocol, "right"), protocol)
    fingers = [row for row, name in enumerate(protocol.names) if not name.startswith("thumb")]
    np.testing.assert_allclose(model.normals(np.zeros(21))[fingers], [[-1, 0, 0]] * len(fingers), atol=1e-12)


@pytest.mark.parametrize("name", ["thesis25", "mocap13"])
def test_the_derivative_in_the_shape_is_that_of_the_positions(name: str, random_joints: Callable) -> None:
    protocol = load_protocol(name)
    prior = ShapePrior.around(average_subject(protocol, "right"), protocol)
    joints = random_joints(2, np.random.default_rng(8))
    shape = 0.3 * prior.std * np.random.default_rng(9).standard_normal(len(prior.std))
    shape[31:46] = 0.0  # small turns are linearised about the present rotation
    model = prior.model(shape)
    slopes = shape_jacobian(model, model.place(joints), float(np.exp(shape[0])))
    for row in range(len(shape)):
        step = np.zeros(len(shape))
        step[row] = 1e-6
        ahead, behind = (prior.model(shape + sign * step).place(joints).p_m for sign in (1, -1))
        np.testing.assert_allclose(slopes[..., row], (ahead - behind) / 2e-6, atol=1e-7)


def test_other_markers_are_refused() -> None:
    with pytest.raises(Refused, match="fingertips5"):
        MarkerModel(average_subject(load_protocol("thesis25"), "right"), load_protocol("fingertips5"))
