"""The kinematic tracker: a hand model predicts, detections are given to its markers, a filter corrects it.

For each capture: predict pose and joints; give detections to markers, the unambiguous ones first, the rest
against the then smaller uncertainty; correct. Meanwhile the person's hand and the size of the noise are
learnt. What is not seen is an estimate of the model, and lost after a while. After a loss, the postures that
the hand took before and open ones are looked for.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from rehab_app.tracking.complaint import Complaints, unseen
from rehab_app.tracking.description import unknown
from rehab_app.tracking.labelling import NONE, placed_points
from rehab_app.tracking.open_hand import OpenHand
from rehab_app.tracking.other_side import SideCheck
from rehab_app.tracking.pursuit import Pursuit
from rehab_app.tracking.start import LabelledCapture, checked, labelled
from rehab_app.tracking.tracked import Labels, TrackedHand, TrackingState
from sessions.errors import Refused
from sessions.records import Side
from sessions.records.fields import Float64, Int64

_HELD = 450  # captures kept back at most while the hand is looked for; the oldest are given up
_LOOK_EVERY = 10  # captures in vain after which it is asked why
_LABELS_FOR = 30  # captures in which the labels must meet a hand
_FEWEST = 4


class KinematicTracker:
    """Tracks one hand that wears a protocol's markers.

    Args:
        protocol: The markers.
        side: Side of the hand; never inferred.
        subject: The person, if known already; the markers' places are learnt all the same.
        labels: Markers named by a person in the first capture; without them a still, open hand is waited for.

    Raises:
        Refused: A label names no marker of the protocol.
    """

    def __init__(
        self,
        protocol: MarkerProtocol,
        side: Side,
        subject: Subject | None = None,
        labels: Labels | None = None,
    ) -> None:
        self._protocol = protocol
        self._labels = None if labels is None else checked(labels, protocol.names)
        self._pursuit = Pursuit(protocol, side, subject)
        self._open_hand = OpenHand(protocol, side)
        self._complaints = Complaints(protocol, side)
        self._side_check = SideCheck(protocol, side)
        self._held: deque[Detections] = deque(maxlen=_HELD)
        self._looked = 0
        self._complaint: str | None = None

    @property
    def state(self) -> TrackingState:
        """What it is doing."""
        if self._pursuit.begun:
            return "tracking" if self._pursuit.holding else "lost"
        return "calibrating" if self._open_hand.found else "searching"

    @property
    def marker_names(self) -> tuple[str, ...]:
        """Names of the markers."""
        return self._protocol.names

    @property
    def subject(self) -> Subject | None:
        """The person, as far as learnt by now."""
        return self._pursuit.subject

    @property
    def expected_m(self) -> Float64 | None:
        """Where to look next, shape (K, 3); None for everywhere."""
        return self._pursuit.expected_m if self._pursuit.begun else self._open_hand.expected_m

    @property
    def complaint(self) -> str | None:
        """What keeps the hand from being tracked, one sentence; None if nothing does."""
        return self._complaint

    def observe(self, detections: Detections) -> tuple[TrackedHand, ...]:
        """Take one capture; see ``Tracker.observe``."""
        if self._pursuit.begun:
            return (self._pursue(detections),)
        if self._labels is not None:
            return self._begin_labelled(self._labels, detections)
        self._held.append(detections)
        return self._wait(detections)

    def finish(self) -> tuple[TrackedHand, ...]:
        """What is still held back when no more captures come: nothing of it was understood."""
        rest = tuple(self._unknown(one) for one in self._held)
        self._held.clear()
        return rest

    def _begin_labelled(self, labels: Labels, detections: Detections) -> tuple[TrackedHand, ...]:
        """Start from named pixels, in the first capture that shows enough of them."""
        self._looked += 1
        capture = labelled(detections, labels, self.marker_names)
        if int((capture.row != NONE).sum()) >= _FEWEST:
            return (self._begin(capture),)
        self._complaint = "The named pixels meet no blobs: name markers where they are seen."
        if self._looked >= _LABELS_FOR:
            self._labels = None
        return (self._unknown(detections),)

    def _wait(self, detections: Detections) -> tuple[TrackedHand, ...]:
        """Look for a still, open hand; once it was shown for long enough, track all that was held back."""
        primary = detections.rows(np.flatnonzero(detections.view == 0))
        shown = self._open_hand.watch(primary)
        if not self._open_hand.found:
            self._looked += 1
            if self._looked % _LOOK_EVERY == 0:
                self._complaint = self._complaints.searching(self._open_hand.spots_m, len(primary))
            return ()
        self._complaint = None
        if not shown or (match := self._open_hand.first_match) is None:
            return ()
        start_ns = self._open_hand.labelled[0][0]
        try:
            return self._caught_up(start_ns, match)
        except Refused as refused:
            self._complaint = str(refused)
            self._open_hand.forget()
            return ()

    def _caught_up(self, start_ns: int, match: Int64) -> tuple[TrackedHand, ...]:
        """Track all that was held back, from the first capture of the open hand on."""
        result: list[TrackedHand] = []
        for one in self._held:
            if one.t_capture_ns < start_ns:
                result.append(self._unknown(one))
            elif one.t_capture_ns == start_ns:
                rows = np.flatnonzero(one.view == 0)
                row = np.where(match == NONE, NONE, rows[match])
                result.append(self._begin(LabelledCapture(one, row, len(one))))
            else:
                result.append(self._pursue(one))
        self._held.clear()
        return tuple(result)

    def _begin(self, capture: LabelledCapture) -> TrackedHand:
        self._side_check.feed(_named(capture.detections, capture.row))
        return self._pursuit.begin(capture)

    def _pursue(self, detections: Detections) -> TrackedHand:
        tracked = self._pursuit.take(detections)
        if tracked is None:
            self._looked += 1
            if self._looked % _LOOK_EVERY == 0:
                primary = detections.rows(np.flatnonzero(detections.view == 0))
                self._complaint = self._complaints.searching(placed_points(primary))
            return self._unknown(detections)
        self._side_check.feed(_named(detections, tracked.detection))
        never = self._pursuit.never_seen
        missing = unseen([self.marker_names[marker] for marker in never]) if len(never) else None
        self._complaint = self._side_check.complaint or missing
        return tracked

    def _unknown(self, detections: Detections) -> TrackedHand:
        return unknown(detections.t_capture_ns, len(self.marker_names), self.state)


def _named(detections: Detections, row: Int64) -> Float64:
    """Points of the markers' detections, NaN where there is none or it has no depth, shape (M, 3)."""
    if not len(detections):
        return np.full((len(row), 3), np.nan)
    return np.where((row != NONE)[:, None], detections.p_camera_m[row], np.nan)
