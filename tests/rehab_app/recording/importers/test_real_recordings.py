from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehab_app.geometry.rotation import matrix_from_wxyz
from rehab_app.hand.pose_fit import PoseFitter
from rehab_app.recording.importers import ImportedTake, import_recording
from sessions.records import JOINTS, Status


@pytest.fixture(scope="module")
def mocap(shared_data: Path) -> ImportedTake:
    return import_recording(shared_data / "mocap_hand_dfki" / "recording.tsv", "right")


@pytest.fixture(scope="module")
def video(shared_data: Path) -> ImportedTake:
    return import_recording(shared_data / "human_hand_video" / "landmarks_m.npz", "right")


def held_out_m(take: ImportedTake, marker: str, every: int) -> float:
    """Median distance of a marker from where the others predict it."""
    row = take.protocol.names.index(marker)
    seen = take.series.p_camera_m[::every].copy()
    truth = seen[:, row].copy()
    seen[:, row] = np.nan
    fitter = PoseFitter(take.subject, take.protocol)
    fit = fitter.fit(seen)
    local = fitter.model.positions(fit.joints_rad)[:, row] * fit.size[:, None]
    predicted = np.einsum("nij,nj->ni", matrix_from_wxyz(fit.q_wxyz), local) + fit.p_palm_m
    return float(np.nanmedian(np.linalg.norm(predicted - truth, axis=1)))


def test_motion_capture_of_a_real_hand(mocap: ImportedTake) -> None:
    assert (mocap.protocol.name, mocap.landmarks, mocap.frames, mocap.gaps) == ("mocap13", 13, 4500, 14)
    assert mocap.duration_s == pytest.approx(44.99)
    assert mocap.residual_m < 0.0015
    assert 0.17 < mocap.subject.geometry.length_m < 0.22
    lost = ~mocap.series.seen[:, mocap.protocol.names.index("thumb_tip")]
    assert lost.mean() == pytest.approx(0.08, abs=0.03)
    status = mocap.fit.joint_status[:, JOINTS.index("thumb_ip")]
    assert (status[lost] != Status.MEASURED).all()
    assert (status[~lost] == Status.MEASURED).mean() > 0.95


def test_landmarks_of_a_real_hand(video: ImportedTake) -> None:
    assert (video.protocol.name, video.landmarks, video.frames, video.gaps) == ("mediapipe21", 21, 621, 0)
    assert video.duration_s == pytest.approx(620 / 30)
    assert video.residual_m < 0.005
    pip = video.fit.joints_rad[:, JOINTS.index("middle_pip")]
    assert np.rad2deg(np.percentile(pip, 99) - np.percentile(pip, 1)) > 70  # it makes fists


@pytest.mark.parametrize(
    ("marker", "most_m"), [("hand_top", 0.002), ("index_middle", 0.005), ("little_tip", 0.006)]
)
def test_other_markers_predict_one_left_out(mocap: ImportedTake, marker: str, most_m: float) -> None:
    assert held_out_m(mocap, marker, 25) < most_m


@pytest.mark.parametrize(
    ("marker", "most_m"), [("middle_mcp", 0.005), ("ring_dip", 0.006), ("index_pip", 0.008)]
)
def test_other_landmarks_predict_one_left_out(video: ImportedTake, marker: str, most_m: float) -> None:
    assert held_out_m(video, marker, 5) < most_m
