"""The sequence made of a real hand's motion capture: camera, shares, the figure of a simple tracker."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.bench.tracking.mocap import mocap_sequence
from tests.bench.tracking.peers import hungarian_3d, oracle
from tests.bench.tracking.score import score


def test_clean_is_a_projection_of_the_recording(shared_data: Path) -> None:
    one = mocap_sequence(shared_data, 0, noisy=False)
    assert len(one.t_ns) == 1350
    seen = one.visible
    assert ((one.pixel_px[seen] > 0.0) & (one.pixel_px[seen] < [640.0, 480.0])).all()
    assert np.mean(one.p_camera_m[seen], axis=0) == pytest.approx([0.0, 0.0, 0.7], abs=1e-3)
    spread = np.std(one.p_camera_m[seen], axis=0)
    assert spread.argmin() == 2  # the camera looks along the axis of least variance
    for k, detections in one.received():
        assert np.allclose(detections.pixel_px, one.pixel_px[k, one.owner[k]])
    assert score(one, oracle(one)).idf1 == 1.0


def test_noisy_has_the_stated_shares(shared_data: Path) -> None:
    one = mocap_sequence(shared_data, 1)
    own = sum(int((owner >= 0).sum()) for owner in one.owner[1:])
    assert own / one.visible[1:].sum() == pytest.approx(0.97, abs=0.005)
    assert {int((owner < 0).sum()) for owner in one.owner} == {2}
    errors = np.concatenate(
        [
            d.pixel_px[o >= 0] - one.pixel_px[k, o[o >= 0]]
            for k, (d, o) in enumerate(zip(one.detections, one.owner, strict=True))
        ]
    )
    assert np.std(errors) == pytest.approx(0.6, rel=0.03)


def test_independent_markers_lose_names_on_a_real_hand(shared_data: Path) -> None:
    results = [
        score(one, hungarian_3d(one)) for one in (mocap_sequence(shared_data, seed) for seed in (2, 3))
    ]
    assert all(0.75 < one.idf1 < 0.98 for one in results)


def test_the_camera_on_the_other_side_is_turned_about_the_long_axis(shared_data: Path) -> None:
    one, other = (
        mocap_sequence(shared_data, 0, noisy=False, side_of_axis=sign, frames=20) for sign in (1, -1)
    )
    assert other.p_camera_m - [0.0, 0.0, 0.7] == pytest.approx(
        (one.p_camera_m - [0.0, 0.0, 0.7]) * [1.0, -1.0, -1.0]
    )
