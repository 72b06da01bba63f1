"""The first second: an open, still hand is given its names, and the person's hand is learnt from it."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.calibration import calibrate_subject
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject, average_subject
from rehab_app.tracking.labelling import NONE, label_open_hand, placed_points
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64, Int64

FRAMES = 20
"""Frames of a still hand that the subject is learnt from."""
_MEANS = 5
_STILL_M = 0.012
_MISSING = 2
_FIT_M = 0.012


class OpenHand:
    """Watches detections until a still, open hand has shown itself for long enough.

    Args:
        protocol: The markers that it wears.
        side: Side of the hand.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side) -> None:
        self._protocol = protocol
        self._side: Side = side
        self._shapes = open_shapes(MarkerModel(average_subject(protocol, side), protocol))
        self._first: Float64 | None = None
        self._frames: list[tuple[int, Float64]] = []
        self._match: Int64 | None = None

    @property
    def found(self) -> bool:
        """Whether an open hand is in view and being learnt."""
        return self._first is not None

    @property
    def labelled(self) -> tuple[tuple[int, Float64], ...]:
        """Capture time and markers (M, 3) of each frame labelled so far, NaN where one is missing."""
        return tuple(self._frames)

    @property
    def expected_m(self) -> Float64 | None:
        """Where the markers were when the hand was found, shape (K, 3)."""
        return None if self._first is None else self._first[np.isfinite(self._first).all(axis=1)]

    @property
    def first_match(self) -> Int64 | None:
        """Detection of each marker in the first of those frames, shape (M,)."""
        return self._match

    def watch(self, detections: Detections) -> bool:
        """Take one capture; whether enough of them show a still hand by now."""
        points = placed_points(detections)
        if self._first is None or (match := _near(self._first, points)) is None:
            self._begin(detections.t_capture_ns, points)
            return False
        self._frames.append((detections.t_capture_ns, _picked(points, match)))
        return len(self._frames) >= FRAMES

    def feed(self, detections: Detections) -> Subject | None:
        """Take one capture; the subject once enough of them show a still hand.

        Raises:
            Refused: What kept still is no human hand.
        """
        if not self.watch(detections):
            return None
        return calibrate_subject(self._means(), self._protocol, self._side)

    def forget(self) -> None:
        """Begin anew."""
        self._first, self._frames, self._match = None, [], None

    def _means(self) -> LandmarkSeries:
        """Means over a few frames each: of a still hand they tell as much, and the fit is quicker."""
        points = np.array([p_m for _, p_m in self._frames]).reshape(_MEANS, -1, len(self._protocol.names), 3)
        seen = np.isfinite(points)
        mean = np.where(seen, points, 0.0).sum(axis=1) / np.where(seen.any(axis=1), seen.sum(axis=1), np.nan)
        times = (
            np.array([t_ns for t_ns, _ in self._frames], dtype=np.float64).reshape(_MEANS, -1).mean(axis=1)
        )
        return LandmarkSeries(1e-9 * (times - times[0]), self._protocol.names, mean)

    def _begin(self, t_ns: int, points: Float64) -> None:
        """Look for an open hand anew; what was collected of one that moved is dropped."""
        self.forget()
        found = label_open_hand(points, self._shapes, missing=_MISSING)
        if found is not None and found.residual_m < _FIT_M:
            self._first, self._match = _picked(points, found.detection), found.detection
            self._frames = [(t_ns, self._first)]


def open_shapes(model: MarkerModel) -> Float64:
    """Markers of open hands, thumb out or in, fingers apart or together, shape (6, M, 3), palm frame."""
    shapes: list[Float64] = []
    for thumb_deg in (-25.0, 0.0, 25.0):
        for spread in (0.0, 1.0):
            joints = np.zeros(len(JOINTS))
            joints[JOINTS.index("thumb_cmc_abduction")] = np.deg2rad(thumb_deg)
            for finger, angle_deg in (("index", 8.0), ("ring", -6.0), ("little", -12.0)):
                joints[JOINTS.index(f"{finger}_mcp_abduction")] = spread * np.deg2rad(angle_deg)
            shapes.append(model.positions(joints))
    return np.array(shapes)


def _near(first_m: Float64, seen_m: Float64) -> Int64 | None:
    """The detection that stayed nearest to each marker, shape (M,); None if the hand did not keep still."""
    if len(seen_m) < len(first_m) - 2 * _MISSING:
        return None
    apart = np.linalg.norm(np.nan_to_num(first_m, nan=1e3)[:, None] - seen_m, axis=2)
    match = np.where(apart.min(axis=1) < _STILL_M, apart.argmin(axis=1), NONE)
    # a detection that two markers claim belongs to neither
    used, count = np.unique(match[match != NONE], return_counts=True)
    match[np.isin(match, used[count > 1])] = NONE
    return match if int((match == NONE).sum()) <= 2 * _MISSING else None


def _picked(seen_m: Float64, match: Int64) -> Float64:
    """Points of the matched detections, NaN where there is none, shape (M, 3)."""
    return np.where((match != NONE)[:, None], seen_m[match], np.nan)
