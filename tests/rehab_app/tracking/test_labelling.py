"""Names for an open hand: whatever its turn, size, side and clutter."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.subject import average_subject
from rehab_app.tracking.labelling import NONE, label_open_hand
from rehab_app.tracking.open_hand import open_shapes
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64

PROTOCOL = load_protocol("thesis25")
UPRIGHT = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


def shapes(side: Side) -> Float64:
    return open_shapes(MarkerModel(average_subject(PROTOCOL, side), PROTOCOL))


def seen_hand(side: Side, seed: int) -> tuple[Float64, np.random.Generator]:
    """Markers of some open hand with its back to the camera, rolled at random, (25, 3)."""
    rng = np.random.default_rng(seed)
    model = MarkerModel(average_subject(PROTOCOL, side, rng.uniform(0.16, 0.22)), PROTOCOL)
    joints = rng.normal(0.0, 0.07, len(JOINTS))
    tilt = Rotation.from_rotvec(rng.uniform(-0.4, 0.4, 3)).as_matrix()
    roll = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0.0, 2 * np.pi)]).as_matrix()
    points = model.positions(joints) + rng.normal(0.0, 0.001, (25, 3))
    return points @ (roll @ tilt @ UPRIGHT).T + [0.02, -0.01, 0.7], rng


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("side", ["right", "left"])
def test_every_marker_gets_its_name(side: Side, seed: int) -> None:
    points, rng = seen_hand(side, seed)
    clutter = points.mean(axis=0) + rng.uniform(-0.12, 0.12, (seed, 3))
    order = rng.permutation(25 + seed)
    labelling = label_open_hand(np.vstack([points, clutter])[order], shapes(side))
    assert labelling is not None
    assert np.array_equal(order[labelling.detection], np.arange(25))
    assert labelling.residual_m < 0.012


def test_two_missing_markers_stay_without_a_detection() -> None:
    points, _ = seen_hand("right", 3)
    labelling = label_open_hand(np.delete(points, [4, 17], axis=0), shapes("right"))
    assert labelling is not None
    assert np.flatnonzero(labelling.detection == NONE).tolist() == [4, 17]


def test_what_is_no_hand_gets_no_names() -> None:
    rng = np.random.default_rng(0)
    assert (
        label_open_hand(rng.uniform(-0.3, 0.3, (25, 3)) + np.array([0.0, 0.0, 0.9]), shapes("right")) is None
    )
    assert label_open_hand(np.empty((0, 3)), shapes("right")) is None
    assert label_open_hand(np.tile([0.0, 0.0, 0.7], (25, 1)), shapes("right")) is None
