from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rehab_app.geometry.rotation import matrix_from_wxyz
from rehab_app.hand.pose_fit import PoseFitter
from rehab_app.hand.pose_prior import JointPrior
from robot_iface.kinematics import forward
from sessions.errors import Refused
from sessions.records import JOINTS, Status
from sessions.records.names import SIDES

TIPS = [3, 7, 11, 15, 19]


@pytest.mark.parametrize("side", SIDES)
def test_without_noise_the_hand_is_found(side: str, scene: Callable, random_joints: Callable) -> None:
    truth = scene("thesis25", side, random_joints(40, np.random.default_rng(1)), 2)
    fit = PoseFitter(truth.subject, truth.protocol).fit(truth.p_camera_m, 1e-4)
    np.testing.assert_allclose(fit.joints_rad, truth.joints_rad, atol=2e-3)
    np.testing.assert_allclose(fit.p_palm_m, truth.p_palm_m, atol=1e-4)
    np.testing.assert_allclose(matrix_from_wxyz(fit.q_wxyz), truth.rotation, atol=2e-3)
    assert fit.residual_m.max() < 1e-4
    assert (fit.joint_status == Status.MEASURED).all()


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("noise_m", [0.001, 0.003])
def test_the_covariance_tells_the_error(
    side: str, noise_m: float, scene: Callable, random_joints: Callable
) -> None:
    rng = np.random.default_rng(3)
    truth = scene("thesis25", side, random_joints(400, rng), 4)
    seen = truth.series(noise_m, rng).p_camera_m
    fit = PoseFitter(truth.subject, truth.protocol).fit(seen)
    np.testing.assert_allclose(np.median(fit.noise_m), noise_m, rtol=0.1)
    std = np.sqrt(np.diagonal(fit.joint_covariance_rad2, axis1=1, axis2=2))
    within = np.abs(fit.joints_rad - truth.joints_rad) < 1.96 * std
    assert 0.92 < within.mean() < 0.985
    error = fit.fingertips_palm_m - forward(truth.subject.geometry, truth.joints_rad).landmarks_m[:, TIPS]
    trace = np.trace(fit.fingertip_covariance_m2, axis1=2, axis2=3)
    np.testing.assert_allclose(np.sqrt((error**2).sum(2).mean(0)), np.sqrt(trace.mean(0)), rtol=0.25)


def test_the_camera_does_not_matter(scene: Callable, random_joints: Callable) -> None:
    rng = np.random.default_rng(5)
    truth = scene("mocap13", "right", random_joints(20, rng), 6)
    seen = truth.series(0.001, rng).p_camera_m
    moved = seen @ Rotation.from_rotvec([0.4, -1.0, 2.0]).as_matrix().T + [1.0, -2.0, 3.0]
    fitter = PoseFitter(truth.subject, truth.protocol)
    here, there = fitter.fit(seen, 0.001), fitter.fit(moved, 0.001)
    np.testing.assert_allclose(here.joints_rad, there.joints_rad, atol=1e-3)
    np.testing.assert_allclose(here.residual_m, there.residual_m, atol=1e-6)


def test_the_same_frames_give_the_same_numbers(scene: Callable, random_joints: Callable) -> None:
    rng = np.random.default_rng(7)
    truth = scene("mediapipe21", "left", random_joints(50, rng), 8)
    seen = truth.series(0.002, rng).p_camera_m
    fitter = PoseFitter(truth.subject, truth.protocol)
    first, second = fitter.fit(seen), fitter.fit(seen)
    np.testing.assert_array_equal(first.joints_rad, second.joints_rad)
    np.testing.assert_array_equal(first.joint_covariance_rad2, second.joint_covariance_rad2)


def test_gaps_stay_gaps(scene: Callable, random_joints: Callable) -> None:
    rng = np.random.default_rng(9)
    truth = scene("thesis25", "right", random_joints(6, rng), 10)
    seen = truth.series(0.001, rng).p_camera_m
    names = truth.protocol.names
    index = [row for row, name in enumerate(names) if name.startswith("index")]
    seen[1, index] = np.nan  # nothing of a finger
    seen[2, names.index("index_tip")] = np.nan  # only its tip
    seen[3] = np.nan  # nothing at all
    seen[4, 2:] = np.nan  # two markers
    fit = PoseFitter(truth.subject, truth.protocol).fit(seen, 0.001)
    finger = [row for row, joint in enumerate(JOINTS) if joint.startswith("index")]
    assert np.isnan(fit.joints_rad[1, finger]).all()
    assert (fit.joint_status[1, finger] == Status.LOST).all()
    assert np.isnan(fit.fingertips_palm_m[1, 1]).all()
    assert np.isfinite(np.delete(fit.joints_rad[1], finger)).all()
    dip = JOINTS.index("index_dip")
    assert fit.joint_status[2, dip] == Status.ESTIMATED
    assert np.isfinite(fit.joints_rad[2, dip])
    assert fit.joint_covariance_rad2[2, dip, dip] > 4 * fit.joint_covariance_rad2[0, dip, dip]
    for row in (3, 4):
        assert np.isnan(fit.joints_rad[row]).all()
        assert np.isnan(fit.p_palm_m[row]).all()
        assert np.isnan(fit.residual_m[row])
        assert (fit.joint_status[row] == Status.LOST).all()


def test_a_prediction_carries_a_hidden_finger_as_an_estimate(
    scene: Callable, random_joints: Callable
) -> None:
    rng = np.random.default_rng(11)
    truth = scene("thesis25", "right", random_joints(3, rng), 12)
    fitter = PoseFitter(truth.subject, truth.protocol)
    before = fitter.fit(truth.p_camera_m, 0.001)
    seen = truth.p_camera_m.copy()
    ring = [row for row, name in enumerate(truth.protocol.names) if name.startswith("ring")]
    seen[:, ring] = np.nan
    prior = JointPrior(truth.joints_rad, np.full(21, 0.1))
    fit = fitter.fit(seen, 0.001, initial=before, prior=prior)
    joints = [row for row, joint in enumerate(JOINTS) if joint.startswith("ring")]
    np.testing.assert_allclose(fit.joints_rad[:, joints], truth.joints_rad[:, joints], atol=0.06)
    assert (fit.joint_status[:, joints] == Status.ESTIMATED).all()


def test_what_is_measured_does_not_depend_on_what_was_expected(
    scene: Callable, random_joints: Callable
) -> None:
    rng = np.random.default_rng(19)
    truth = scene("thesis25", "right", random_joints(30, rng), 20)
    seen = truth.series(0.001, rng).p_camera_m
    seen[rng.random(seen.shape[:2]) < 0.15] = np.nan
    fitter = PoseFitter(truth.subject, truth.protocol)
    unled = fitter.fit(seen, 0.001)
    led = fitter.fit(seen, 0.001, prior=JointPrior(truth.joints_rad, np.full(21, 0.05)))
    measured = unled.joint_status == Status.MEASURED
    assert 0.3 < measured.mean() < 0.99
    assert (measured == (led.joint_status == Status.MEASURED)).mean() > 0.98


def test_a_warm_start_reaches_the_same_hand(scene: Callable, random_joints: Callable) -> None:
    rng = np.random.default_rng(13)
    truth = scene("thesis25", "left", random_joints(20, rng), 14)
    seen = truth.series(0.001, rng).p_camera_m
    fitter = PoseFitter(truth.subject, truth.protocol)
    cold = fitter.fit(seen, 0.001)
    near = replace(cold, joints_rad=cold.joints_rad + 0.1 * rng.standard_normal(cold.joints_rad.shape))
    np.testing.assert_allclose(fitter.fit(seen, 0.001, near).joints_rad, cold.joints_rad, atol=2e-3)


def test_one_swapped_marker_does_little_harm(scene: Callable, random_joints: Callable) -> None:
    rng = np.random.default_rng(15)
    truth = scene("thesis25", "right", random_joints(10, rng), 16)
    seen = truth.series(0.001, rng).p_camera_m
    seen[:, truth.protocol.names.index("middle_mcp")] += [0.0, 0.05, 0.0]
    fit = PoseFitter(truth.subject, truth.protocol).fit(seen, 0.001)
    fingers = [row for row, joint in enumerate(JOINTS) if joint.startswith(("index", "little"))]
    assert np.abs(fit.joints_rad - truth.joints_rad)[:, fingers].max() < np.deg2rad(12)


def test_a_network_s_wavering_size_is_taken_out(scene: Callable, random_joints: Callable) -> None:
    rng = np.random.default_rng(17)
    truth = scene("mediapipe21", "right", random_joints(60, rng), 18)
    size = np.exp(0.08 * rng.standard_normal(60))
    arms = truth.p_camera_m - truth.p_palm_m[:, None]
    seen = truth.p_palm_m[:, None] + arms * size[:, None, None] + 0.001 * rng.standard_normal(arms.shape)
    fit = PoseFitter(truth.subject, truth.protocol).fit(seen, 0.001)
    np.testing.assert_allclose(fit.size, size, rtol=0.03)
    assert np.sqrt(np.mean((fit.joints_rad - truth.joints_rad) ** 2)) < np.deg2rad(5)


def test_markers_in_another_order_are_refused(scene: Callable) -> None:
    truth = scene("thesis25", "right", np.zeros((2, 21)), 1)
    with pytest.raises(Refused, match="frames, 25, 3"):
        PoseFitter(truth.subject, truth.protocol).fit(truth.p_camera_m[:, :20])
