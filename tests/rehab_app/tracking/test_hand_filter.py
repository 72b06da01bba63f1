"""Laws of the hand's filter: time, motion, honesty of its covariance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import KINECT
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.subject import average_subject
from rehab_app.tracking.hand_filter import placed, plain_pairs, updated
from rehab_app.tracking.hand_state import POSITIONS, HandState, at_rest, predicted
from rehab_app.tracking.sight import sight
from sessions.records import JOINTS
from sessions.records.fields import Float64

PROTOCOL = load_protocol("thesis25")
MODEL = MarkerModel(average_subject(PROTOCOL, "right"), PROTOCOL)
UPRIGHT = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
PLACE = np.array([0.02, 0.08, 0.7])
STD = np.concatenate([np.full(3, 0.05), np.full(3, 0.01), np.full(21, 0.1)])
WOBBLE_M2 = 0.0005**2
ALL = np.arange(25)


def hand(joints_rad: Float64 | None = None) -> HandState:
    joints = np.full(21, 0.2) if joints_rad is None else joints_rad
    return at_rest(0, UPRIGHT, PLACE, joints, np.diag(STD**2))


def seen(points_m: Float64, *, depth_m: Float64 | None = None) -> Detections:
    count = len(points_m)
    return lifted(
        33_333_333,
        KINECT.project(points_m),
        points_m[:, 2] if depth_m is None else depth_m,
        KINECT,
        pixel_std_px=np.full(count, 0.5),
        depth_std_m=np.full(count, 0.002),
        similarity=np.ones(count),
    )


def test_time_passes_alike_in_one_step_and_in_many() -> None:
    rng = np.random.default_rng(0)
    start = hand()
    start = HandState(
        0, start.rotation, start.p_m, start.joints_rad, 0.3 * rng.standard_normal(27), start.covariance
    )
    once = predicted(start, 60_000_000)
    often = start
    for step in range(1, 7):
        often = predicted(often, 10_000_000 * step)
    np.testing.assert_allclose(often.joints_rad, once.joints_rad, atol=1e-9)
    np.testing.assert_allclose(often.rate, once.rate, atol=1e-9)
    np.testing.assert_allclose(
        often.covariance[6:27, 6:27], once.covariance[6:27, 6:27], rtol=1e-6, atol=1e-9
    )
    assert np.linalg.eigvalsh(once.covariance).min() > -1e-12


def test_unseen_the_hand_is_known_less_and_less_but_never_less_than_nothing() -> None:
    state, traces = hand(), []
    for step in range(1, 40):
        state = predicted(state, 100_000_000 * step)
        traces.append(float(np.trace(state.joint_covariance_rad2)))
    assert (np.diff(traces) >= -1e-9).all()
    assert np.sqrt(np.diagonal(state.joint_covariance_rad2)).max() <= 0.9 + 1e-9


def test_slopes_are_those_of_the_markers() -> None:
    state = hand()
    here = placed(MODEL, state)
    for row in range(POSITIONS):
        step = np.zeros(POSITIONS)
        step[row] = 1e-6
        ahead, back = placed(MODEL, state.moved(step)).p_m, placed(MODEL, state.moved(-step)).p_m
        np.testing.assert_allclose(here.slopes[:, :, row], (ahead - back) / 2e-6, atol=1e-7)


def test_a_hand_turned_and_shifted_with_its_camera_is_fitted_alike() -> None:
    rng = np.random.default_rng(1)
    truth = hand(np.full(21, 0.2) + 0.05 * rng.standard_normal(21))
    points = placed(MODEL, truth).p_m + 0.0003 * rng.standard_normal((25, 3))
    pairs = plain_pairs(ALL, ALL)
    one = updated(MODEL, hand(), sight(seen(points)), pairs, WOBBLE_M2, 0.03).state
    turned = Rotation.from_rotvec([0.0, 0.0, 0.4]).as_matrix()
    start = at_rest(0, turned @ UPRIGHT, turned @ PLACE, np.full(21, 0.2), np.diag(STD**2))
    other = updated(MODEL, start, sight(seen(points @ turned.T)), pairs, WOBBLE_M2, 0.03).state
    np.testing.assert_allclose(other.joints_rad, one.joints_rad, atol=1e-4)
    np.testing.assert_allclose(other.rotation, turned @ one.rotation, atol=1e-4)


def test_what_the_filter_says_of_its_error_is_true() -> None:
    rng = np.random.default_rng(2)
    squares = []
    for _ in range(150):
        joints = 0.3 + STD[6:] * rng.standard_normal(21)
        step = np.concatenate([STD[:6] * rng.standard_normal(6), np.zeros(21)])
        truth = hand(joints).moved(step)
        place = placed(MODEL, truth).p_m
        pixel = KINECT.project(place + np.sqrt(WOBBLE_M2) * rng.standard_normal((25, 3)))
        points = KINECT.lift(pixel + 0.5 * rng.standard_normal((25, 2)), place[:, 2])
        depth = place[:, 2] + rng.normal(0.0, np.sqrt(0.002**2 + WOBBLE_M2), 25)
        view = sight(seen(points, depth_m=depth))
        start = hand(np.full(21, 0.3))
        after = updated(MODEL, start, view, plain_pairs(ALL, ALL), WOBBLE_M2, 0.0).state
        off = after.joints_rad - joints
        squares.append(off @ np.linalg.solve(after.joint_covariance_rad2, off))
    assert np.mean(squares) == pytest.approx(len(JOINTS), rel=0.25)


def test_a_wild_depth_moves_nothing_unless_it_insists() -> None:
    truth = hand()
    points = placed(MODEL, truth).p_m
    depth = points[:, 2].copy()
    tip = PROTOCOL.names.index("index_tip")
    depth[tip] += 0.06
    view = sight(seen(points, depth_m=depth))
    pairs = plain_pairs(ALL, ALL)
    still = updated(MODEL, truth, view, pairs, WOBBLE_M2, 0.0).state
    assert np.abs(still.joints_rad - truth.joints_rad).max() < np.deg2rad(3.0)
    pairs.insisted[tip] = True
    moved = updated(MODEL, truth, view, pairs, WOBBLE_M2, 0.0).state
    assert np.abs(moved.joints_rad - still.joints_rad).max() > np.deg2rad(4.0)


def test_without_any_depth_the_rays_still_tell_the_joints() -> None:
    joints = np.full(21, 0.2)
    joints[JOINTS.index("index_mcp_abduction")] = 0.3
    points = placed(MODEL, hand(joints)).p_m
    view = sight(seen(points, depth_m=np.full(25, np.nan)))
    after = updated(MODEL, hand(), view, plain_pairs(ALL, ALL), WOBBLE_M2, 0.0).state
    column = JOINTS.index("index_mcp_abduction")
    assert after.joints_rad[column] == pytest.approx(0.3, abs=0.03)
    variance = np.diagonal(after.covariance)
    assert variance[5] > 3.0 * variance[3]  # how far it is stays less certain than where it is
