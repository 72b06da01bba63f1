"""The first second: an open, still hand is given its names from what stands still in the image."""

from __future__ import annotations

from collections import deque

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import average_subject
from rehab_app.tracking.labelling import NONE, Labelling, label_open_hand, placed_points
from rehab_app.tracking.still_spots import nearest_in_image, still_spots
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64, Int64

FRAMES = 20
"""Captures of a still hand after which tracking begins."""
_LOOK_AT = 9  # captures that the names are read from
_LOOK_EVERY = 3
_SHARE = 0.5  # of the captures, in which a marker must be seen
_STILL_M = 0.012
_MISSING = 2
_MISSING_AT_ONCE = 0.3  # share of the markers that one capture may lack
_BLANKS = 3
_FIT_M = 0.012
_MIRRORED = 0.8
_RIVAL = 0.6  # share of the markers that a second hand must show


class OpenHand:
    """Watches detections until a still, open hand has shown itself for long enough.

    Names are read from spots where blobs keep appearing, not from one capture, so that misses, flickering
    blobs and bad depths in each capture do not matter. A hand of the other side is refused, and so are two.

    Args:
        protocol: The markers that it wears.
        side: Side of the hand.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side) -> None:
        self._count = len(protocol.names)
        other: Side = "left" if side == "right" else "right"
        self._shapes, self._mirrored = (
            open_shapes(MarkerModel(average_subject(protocol, one), protocol)) for one in (side, other)
        )
        self._recent: deque[Detections] = deque(maxlen=_LOOK_AT)
        self._watched = 0
        self._blanks = 0
        self._spots: Float64 | None = None
        self._frames: list[tuple[int, Float64, Int64]] = []

    @property
    def found(self) -> bool:
        """Whether an open hand is in view and being watched."""
        return self._spots is not None

    @property
    def labelled(self) -> tuple[tuple[int, Float64], ...]:
        """Capture time and markers (M, 3) of each frame labelled so far, NaN where one is missing."""
        return tuple((t_ns, p_m) for t_ns, p_m, _ in self._frames)

    @property
    def expected_m(self) -> Float64 | None:
        """Where the markers were when the hand was found, shape (K, 3)."""
        return None if self._spots is None else self._spots[np.isfinite(self._spots).all(axis=1)]

    @property
    def first_match(self) -> Int64 | None:
        """Detection of each marker in the first of those frames, shape (M,)."""
        return self._frames[0][2] if self._frames else None

    @property
    def spots_m(self) -> Float64:
        """What stood still of late, named or not, shape (K, 3)."""
        return still_spots(self._recent, _SHARE) if self._recent else np.empty((0, 3))

    def watch(self, detections: Detections) -> bool:
        """Take one capture; whether enough of them show a still hand by now."""
        self._recent.append(detections)
        self._watched += 1
        if self._spots is None:
            if len(self._recent) == _LOOK_AT and self._watched % _LOOK_EVERY == 0:
                self._look()
            return False
        if not self._follow(detections, self._spots):
            self.forget()
            return False
        return len(self._frames) >= FRAMES and self._lasting()

    def forget(self) -> None:
        """Begin anew."""
        self._spots, self._frames, self._blanks = None, [], 0

    def _look(self) -> None:
        """Look for an open hand in what stood still."""
        spots = self.spots_m
        found = self._laid(spots, self._shapes, _MISSING)
        if found is None or self._doubtful(spots, found):
            return
        named = found.detection != NONE
        self._spots = np.where(named[:, None], spots[found.detection], np.nan)
        for one in self._recent:
            self._follow(one, self._spots)
        if not self._frames:
            self.forget()

    def _doubtful(self, spots: Float64, found: Labelling) -> bool:
        """Whether the other side's hand fits better, or what is left over is a hand as well."""
        mirrored = self._laid(spots, self._mirrored, _MISSING)
        if mirrored is not None and mirrored.residual_m < _MIRRORED * found.residual_m:
            return True
        rest = np.delete(spots, found.detection[found.detection != NONE], axis=0)
        missing = round((1.0 - _RIVAL) * self._count)
        return any(self._laid(rest, one, missing) is not None for one in (self._shapes, self._mirrored))

    def _follow(self, detections: Detections, spots: Float64) -> bool:
        """Name the blobs that are still where they were; whether the hand is still there."""
        match = nearest_in_image(spots, detections, _STILL_M)
        named = int(np.isfinite(spots[:, 0]).sum())
        if int((match != NONE).sum()) < (1.0 - _MISSING_AT_ONCE) * named:
            self._blanks += 1
            return self._blanks <= _BLANKS
        self._blanks = 0
        points = placed_points(detections)
        seen = np.where((match != NONE)[:, None], points[match], np.nan)
        self._frames.append((detections.t_capture_ns, seen, match))
        return True

    def _lasting(self) -> bool:
        """Whether all but a few markers were seen in most captures; else the hand is forgotten."""
        seen = np.array([match != NONE for _, _, match in self._frames]).mean(axis=0) >= _SHARE
        if int(seen.sum()) >= self._count - _MISSING:
            return True
        self.forget()
        return False

    @staticmethod
    def _laid(points_m: Float64, shapes: Float64, missing: int) -> Labelling | None:
        found = label_open_hand(points_m, shapes, missing=missing)
        return found if found is not None and found.residual_m < _FIT_M else None


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
