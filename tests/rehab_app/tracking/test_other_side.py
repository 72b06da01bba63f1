"""A hand of the other side than was stated is said, and never a right one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.hand.protocol import load_protocol
from rehab_app.tracking import KinematicTracker, Labels
from rehab_app.tracking.other_side import SideCheck, fit_costs
from sessions.records import Side
from sessions.records.fields import Float64
from tests.bench.tracking.mocap import mocap_sequence

OTHER: dict[Side, Side] = {"right": "left", "left": "right"}
FRAMES = 30


def complaint(made: PointSequence, stated: Side) -> str | None:
    labels = Labels(made.protocol.names, made.init_pixel_px)
    tracker = KinematicTracker(made.protocol, stated, labels=labels)
    for one in made.detections:
        tracker.observe(one)
    return tracker.complaint


def named(made: PointSequence) -> Float64:
    """Markers of every seventh capture, named by their owners, (N, M, 3)."""
    points = np.full((5, len(made.protocol.names), 3), np.nan)
    for row in range(5):
        owner = made.owner[7 * row]
        points[row, owner[owner >= 0]] = made.detections[7 * row].p_camera_m[owner >= 0]
    return points


@pytest.mark.parametrize("level", ["easy", "hard"])
@pytest.mark.parametrize("side", ["right", "left"])
def test_a_mirrored_hand_is_said_and_the_right_one_is_not(level: str, side: Side) -> None:
    made = point_sequence(level, 611, FRAMES, side=side)
    assert complaint(made, side) is None
    said = complaint(made, OTHER[side])
    assert said is not None
    assert said.startswith(
        f"The markers fit a {side} hand better than the {OTHER[side]} hand that was stated"
    )


@pytest.mark.parametrize("seed", range(620, 626))
def test_a_hand_fits_its_own_side_better(seed: int) -> None:
    side: Side = "left" if seed % 2 else "right"
    made = point_sequence(("easy", "medium", "hard")[seed % 3], seed, FRAMES, side=side)
    own, other = (fit_costs(named(made), made.protocol, one) for one in (side, OTHER[side]))
    assert np.median(other - own) > 10.0


@pytest.mark.parametrize("side_of_axis", [1, -1])
def test_a_real_hand_is_known_from_both_sides_of_it(shared_data: Path, side_of_axis: int) -> None:
    made = mocap_sequence(shared_data, 3, side_of_axis=side_of_axis, frames=FRAMES)
    assert complaint(made, "right") is None
    assert "fit a right hand better" in (complaint(made, "left") or "")


def test_without_points_nothing_is_said() -> None:
    protocol = load_protocol("thesis25")
    check = SideCheck(protocol, "right")
    for _ in range(100):
        check.feed(np.full((len(protocol.names), 3), np.nan))
    assert check.complaint is None
