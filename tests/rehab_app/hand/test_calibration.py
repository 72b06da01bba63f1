from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rehab_app.hand.calibration import calibrate_subject, spread_frames
from rehab_app.hand.pose_fit import PoseFitter
from rehab_app.hand.series import LandmarkSeries
from robot_iface.kinematics import couple_dip, forward
from sessions.errors import Refused
from sessions.records import JOINTS
from sessions.records.names import SIDES

PIP = JOINTS.index("index_pip")
TIPS = [3, 7, 11, 15, 19]


def moving(frames: int, rng: np.random.Generator) -> np.ndarray:
    """Opening and closing, every finger at its own time."""
    phase = np.linspace(0, 4 * np.pi, frames)[:, None] + rng.uniform(0, 6, 21)
    joints = np.zeros((frames, 21))
    for row, name in enumerate(JOINTS):
        reach = 0.25 if name.endswith("abduction") else 0.7
        offset = 0.0 if name.endswith("abduction") else 0.7
        joints[:, row] = offset + reach * np.sin(phase[:, row])
    joints[:, :5] *= 0.4
    return couple_dip(joints)


@pytest.mark.parametrize(("side", "length_m"), [("right", 0.175), ("left", 0.205)])
def test_a_moving_hand_tells_its_bones(side: str, length_m: float, scene: Callable, person: Callable) -> None:
    rng = np.random.default_rng(1)
    truth = scene("thesis25", side, moving(150, rng), 2, person("thesis25", side, length_m, 3))
    series = truth.series(0.001, rng)
    subject = calibrate_subject(series, truth.protocol, side)
    bones = subject.geometry.bones_m / truth.subject.geometry.bones_m
    assert np.abs(bones - 1).max() < 0.12
    assert abs(subject.geometry.length_m - truth.subject.geometry.length_m) < 0.008
    assert subject.residual_m < 0.003
    fit = PoseFitter(subject, truth.protocol).fit(series.p_camera_m)
    tips = forward(truth.subject.geometry, truth.joints_rad).landmarks_m[:, TIPS]
    assert np.sqrt(((fit.fingertips_palm_m - tips) ** 2).sum(2).mean()) < 0.008


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("length_m", [0.175, 0.200])
def test_forty_degrees_stay_forty_after_a_still_open_hand(
    side: str, length_m: float, scene: Callable, person: Callable
) -> None:
    rng = np.random.default_rng(4)
    still = np.tile(couple_dip(np.full(21, 0.08)), (20, 1))
    bent = np.repeat(still[:1], 60, axis=0)
    bent[:, PIP] += np.deg2rad(40) * 0.5 * (1 - np.cos(np.linspace(0, 2 * np.pi, 60)))
    subject = person("thesis25", side, length_m, 5)
    shown = scene("thesis25", side, still, 6, subject)
    learnt = calibrate_subject(shown.series(0.001, rng), shown.protocol, side)
    movement = scene("thesis25", side, couple_dip(bent), 7, subject)
    fit = PoseFitter(learnt, movement.protocol).fit(movement.series(0.0005, rng).p_camera_m)
    angle = np.rad2deg(fit.joints_rad[:, PIP])
    assert abs((angle[25:35].mean() - np.r_[angle[:3], angle[-3:]].mean()) - 39.0) < 2.0


def test_calibration_is_repeatable_and_bears_gaps(scene: Callable, person: Callable) -> None:
    rng = np.random.default_rng(8)
    truth = scene("mocap13", "right", moving(120, rng), 9, person("mocap13", "right", 0.19, 10))
    series = truth.series(0.001, rng)
    p_m = series.p_camera_m.copy()
    p_m[rng.random(p_m.shape[:2]) < 0.05] = np.nan
    gappy = LandmarkSeries(series.t_s, series.names, p_m)
    first, second = (calibrate_subject(gappy, truth.protocol, "right") for _ in range(2))
    np.testing.assert_array_equal(first.marker_offset_m, second.marker_offset_m)
    assert first.residual_m < 0.003


def test_unknown_places_on_the_palm_are_learnt(scene: Callable, person: Callable) -> None:
    rng = np.random.default_rng(11)
    subject = person("mocap13", "right", 0.19, 12)
    truth = scene("mocap13", "right", moving(200, rng), 13, subject)
    learnt = calibrate_subject(truth.series(0.0005, rng), truth.protocol, "right")
    plate = [truth.protocol.names.index(f"hand_{place}") for place in ("top", "left", "right")]
    ours, theirs = learnt.marker_offset_m[plate], subject.marker_offset_m[plate]
    sizes = [np.linalg.norm(offsets - np.roll(offsets, 1, axis=0), axis=1) for offsets in (ours, theirs)]
    np.testing.assert_allclose(sizes[0], sizes[1], atol=0.002)


def test_spread_frames_prefers_what_differs() -> None:
    rng = np.random.default_rng(14)
    p_m = np.tile(rng.normal(size=(1, 5, 3)), (300, 1, 1)) + 1e-4 * rng.standard_normal((300, 5, 3))
    p_m[150:153] *= 1.5
    series = LandmarkSeries(np.arange(300.0), tuple("abcde"), p_m)
    rows = spread_frames(series, 10)
    assert set(rows) & {150, 151, 152}
    assert len(rows) == 10


def test_what_cannot_be_calibrated_is_refused(scene: Callable) -> None:
    truth = scene("thesis25", "right", np.zeros((4, 21)), 1)
    with pytest.raises(Refused, match="usable frames"):
        calibrate_subject(truth.series(0.001, np.random.default_rng(1)), truth.protocol, "right")
    rng = np.random.default_rng(2)
    noise = LandmarkSeries(np.arange(8.0), truth.protocol.names, rng.normal(size=(8, 25, 3)))
    with pytest.raises(Refused, match="side and protocol"):
        calibrate_subject(noise, truth.protocol, "right")
    with pytest.raises(Refused, match="name the protocol"):
        calibrate_subject(
            LandmarkSeries(np.arange(30.0), tuple("abc"), np.zeros((30, 3, 3))), truth.protocol, "right"
        )
