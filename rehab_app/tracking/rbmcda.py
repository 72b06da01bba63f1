"""The thesis's tracker: markers followed in the image by Monte Carlo data association, a hand fitted behind.

Cordella (2011), section 4.2.3: every marker is a point of its own in the image; no hand model holds them
together. Around that filter stand what a session needs: a start from an open hand or from labels, the third
coordinate from the detections' depth, a new start after the hand was lost, and a hand fitted to what was
measured. Only the tracking camera is used. Without depth, markers are tracked in the image alone and their
points, and the pose, are gaps.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.geometry.view import PRIMARY
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject, average_subject
from rehab_app.tracking.complaint import Complaints, unseen
from rehab_app.tracking.description import unknown
from rehab_app.tracking.labelling import NONE, placed_points
from rehab_app.tracking.open_hand import OpenHand
from rehab_app.tracking.rbmcda_image import ImageTracks
from rehab_app.tracking.rbmcda_pose import LEARNT_FROM, HandBehind, posed
from rehab_app.tracking.rbmcda_settings import RBMCDA, RbmcdaSettings
from rehab_app.tracking.rbmcda_start import found_again
from rehab_app.tracking.start import checked, labelled
from rehab_app.tracking.tracked import Labels, TrackedHand, TrackingState
from sessions.records import Side
from sessions.records.fields import Float64, Int64

_WAITING = 450  # captures kept back at most while an open hand is waited for; the oldest are given up
_PATIENCE = 10  # captures without enough markers before the hand counts as lost
_LOOK_AGAIN = 3  # of so many captures, one is searched for a lost hand
_LOOK_FOR_REST = 15  # and one of so many for lost markers of a hand that is tracked
_LABELS_FOR = 30  # captures in which the labels must meet a hand
_FEWEST = 4  # of them
_COMPLAIN = 10  # of so many captures in vain, one is asked why
_UNSURE_PX = 10.0  # how far from the fitted hand a marker may be that was never seen
_DEPTHLESS = (
    "The camera gives no depth: markers are followed in the image only, the hand's pose is not known."
)


class RbmcdaTracker:
    """Tracks one hand that wears a protocol's markers, in the image of the tracking camera.

    Args:
        protocol: The markers.
        side: Side of the hand; never inferred.
        subject: The person, if known already; otherwise learnt from the first captures with depth.
        labels: Markers named by a person in the first capture; without them an open hand is waited for.
        seed: Of the draws.
        settings: Of the filter.

    Raises:
        Refused: A label names no marker of the protocol.
    """

    def __init__(
        self,
        protocol: MarkerProtocol,
        side: Side,
        subject: Subject | None = None,
        labels: Labels | None = None,
        *,
        seed: int = 0,
        settings: RbmcdaSettings = RBMCDA,
    ) -> None:
        self._protocol = protocol
        self._labels = None if labels is None else checked(labels, protocol.names)
        self._average = MarkerModel(average_subject(protocol, side), protocol)
        self._hand = HandBehind(protocol, side, subject)
        self._tracks = ImageTracks(settings, len(protocol.names), seed)
        self._open_hand = OpenHand(protocol, side) if subject is None and labels is None else None
        self._complaints = Complaints(protocol, side)
        self._waiting: deque[Detections] = deque(maxlen=_WAITING)
        self._held: list[TrackedHand] = []
        self._learning = subject is None
        self._count = 0
        self._misses = _PATIENCE + 1
        self._expected: Float64 | None = None
        self._complaint: str | None = None

    @property
    def state(self) -> TrackingState:
        """What it is doing."""
        if self._open_hand is not None:
            return "calibrating" if self._open_hand.found else "searching"
        if self._misses > _PATIENCE:
            return "lost" if self._tracks.known.size else "searching"
        return "calibrating" if self._held else "tracking"

    @property
    def marker_names(self) -> tuple[str, ...]:
        """Names of the markers."""
        return self._protocol.names

    @property
    def subject(self) -> Subject | None:
        """The person, once calibrated."""
        return self._hand.subject

    @property
    def expected_m(self) -> Float64 | None:
        """Where to look next, shape (K, 3); None for everywhere."""
        if self._open_hand is not None:
            return self._open_hand.expected_m
        if self._expected is None or self._misses > 0:
            return None
        return self._expected[np.isfinite(self._expected).all(axis=1)]

    @property
    def complaint(self) -> str | None:
        """What keeps the hand from being tracked, one sentence; None if nothing does."""
        return self._complaint

    def observe(self, detections: Detections) -> tuple[TrackedHand, ...]:
        """Take one capture; see ``Tracker.observe``."""
        if self._open_hand is None:
            return self._released([self._track(detections)], depth=_has_depth(detections))
        self._waiting.append(detections)
        self._count += 1
        primary, _ = _primary(detections)
        shown = self._open_hand.watch(primary)
        if not self._open_hand.found:
            self._complain(primary)
            return ()
        return self._begun(self._open_hand) if shown else ()

    def finish(self) -> tuple[TrackedHand, ...]:
        """What is still held back when no more captures come."""
        rest = (*self._held, *(self._unknown(one) for one in self._waiting))
        self._held, self._learning = [], False
        self._waiting.clear()
        return rest

    def _begun(self, open_hand: OpenHand) -> tuple[TrackedHand, ...]:
        """Track all that was held back, from the first capture of the open hand on."""
        start_ns, match = open_hand.labelled[0][0], open_hand.first_match
        before = tuple(self._unknown(one) for one in self._waiting if one.t_capture_ns < start_ns)
        after = [one for one in self._waiting if one.t_capture_ns >= start_ns]
        self._open_hand, self._complaint = None, None
        self._waiting.clear()
        self._start(_primary(after[0])[0], np.full(len(self.marker_names), NONE) if match is None else match)
        tracked = [self._track(one) for one in after]
        return before + self._released(tracked, depth=any(_has_depth(one) for one in after))

    def _track(self, detections: Detections) -> TrackedHand:
        """One capture of a hand that was found or is being looked for."""
        seen, rows = _primary(detections)
        self._count += 1
        if self._labels is not None:
            self._start_labelled(self._labels, seen)
        elif self._due(len(seen)):
            self._look(seen)
        if not self._tracks.known.size:
            self._complain(seen)
            return self._unknown(detections)
        markers = self._tracks.follow(seen)
        given = self._tracks.detection != NONE
        enough = int(given.sum()) >= max(2, min(4, len(given) // 3))
        self._misses = 0 if enough else self._misses + 1
        self._expected = markers.p_camera_m
        self._hand.learn(markers)
        pose = self._hand.pose(markers)
        self._start_unseen()
        row = np.full(len(given), NONE, dtype=np.int64)
        row[given] = rows[self._tracks.detection[given]]
        if self._misses > _PATIENCE:
            self._complain(seen)
            return TrackedHand(markers, pose, row, "lost")
        self._complaint = self._reservation(seen)
        return TrackedHand(markers, pose, row, "tracking")

    def _released(self, tracked: list[TrackedHand], *, depth: bool) -> tuple[TrackedHand, ...]:
        """What may be given out: while the person is being learnt nothing, then all, with poses."""
        self._held += tracked
        known = self._hand.fitter is not None
        if self._learning and depth and not known and len(self._held) < LEARNT_FROM:
            return ()
        released = [posed(self._hand, one) if self._learning and known else one for one in self._held]
        self._held, self._learning = [], False
        return tuple(released)

    def _start(self, seen: Detections, match: Int64) -> None:
        """Begin, or begin again, with markers at their detections (M,)."""
        named = np.flatnonzero(match != NONE)
        self._tracks.place(named, seen.pixel_px[match[named]])
        self._misses = 0 if named.size else self._misses

    def _start_labelled(self, labels: Labels, seen: Detections) -> None:
        """Begin at named pixels, in the first capture that shows enough of them."""
        capture = labelled(seen, labels, self._protocol.names)
        met = int((capture.row != NONE).sum()) >= _FEWEST
        if met:
            self._start(capture.detections, capture.row)
        if met or self._count >= _LABELS_FOR:
            self._labels = None

    def _start_unseen(self) -> None:
        """Markers that were never seen begin where the fitted hand has them."""
        missing = np.setdiff1d(np.arange(len(self.marker_names)), self._tracks.known)
        if not missing.size:
            return
        expected, pinhole = self._hand.expected_m, self._tracks.pinhole
        if expected is not None and pinhole is not None and bool((expected[missing, 2] > 0.05).all()):
            self._tracks.place(missing, pinhole.project(expected[missing]), _UNSURE_PX)

    def _due(self, detections: int) -> bool:
        """Whether it is time to search for a lost hand, or for lost markers of a hand that may be open."""
        if self._misses > _PATIENCE:
            return self._count % _LOOK_AGAIN == 0
        missing = len(self.marker_names) - detections
        return self._tracks.any_lost and missing <= 2 and self._count % _LOOK_FOR_REST == 0

    def _look(self, seen: Detections) -> None:
        """Begin again where an open hand, or the hand as it was last, is found."""
        fitter = self._hand.fitter
        known = fitter is not None and _has_depth(seen)
        model = self._average if fitter is None else fitter.model
        found = found_again(seen, model, self._hand.joints_rad, known=known)
        if found is not None:
            self._tracks.restart()
            self._start(seen, found)

    def _complain(self, seen: Detections) -> None:
        if self._count % _COMPLAIN == 0:
            met = "" if self._labels is None else "The named pixels meet no blobs. "
            self._complaint = met + self._complaints.searching(placed_points(seen))

    def _reservation(self, seen: Detections) -> str | None:
        """What is missing from a hand that is tracked."""
        never = self._tracks.never_seen
        if never.size:
            return unseen([self.marker_names[marker] for marker in never])
        return _DEPTHLESS if self._hand.fitter is None and len(seen) and not _has_depth(seen) else None

    def _unknown(self, detections: Detections) -> TrackedHand:
        return unknown(detections.t_capture_ns, len(self.marker_names), self.state)


def _primary(detections: Detections) -> tuple[Detections, Int64]:
    """The detections of the tracking camera and their rows."""
    rows = np.flatnonzero(detections.view == PRIMARY.index)
    return (detections if len(rows) == len(detections) else detections.rows(rows)), rows


def _has_depth(detections: Detections) -> bool:
    """Whether any detection has a place in space."""
    return bool(np.isfinite(detections.p_camera_m[:, 2]).any())
