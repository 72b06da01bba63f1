"""The tracker of a bare hand: its landmarks come with names, so the hand is learnt and fitted, no more.

The person's bone lengths are learnt from the first two seconds of sightings and held from then on: the same
kinematic fit as for markers turns landmarks into joints. Without depth the size of the hand is free in every
capture, as the network knows no scale; with depth it is the person's.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.calibration import calibrate_subject
from rehab_app.hand.pose_fit import HandFit, PoseFitter
from rehab_app.hand.pose_prior import JointPrior
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from rehab_app.hand.records import pose_record
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject
from rehab_app.tracking.bare_hand_points import MEASURED, LandmarkPoints, points_of
from rehab_app.tracking.description import unknown
from rehab_app.tracking.tracked import TrackedHand, TrackingState
from sessions.errors import Refused
from sessions.records import MarkerFrame, Side, Status
from sessions.records.fields import Float64

PROTOCOL = "mediapipe21"
"""The landmarks of a bare hand."""

_LEARNT_FROM = 60
_HELD = 450
_REMEMBERED_NS = 500_000_000  # for so long the hand's last pose tells where it will be
_PATIENCE = 10
_EXPECTED_STD_RAD = 0.35
_DOUBTFUL_M = 0.012  # residual from which the fit begins again from nothing


def bare_hand_protocol(*, metric: bool) -> MarkerProtocol:
    """The 21 landmarks; of free size where no depth image gives them a scale."""
    protocol = load_protocol(PROTOCOL)
    return replace(protocol, size_std=0.0) if metric else protocol


def learn_bare_hand(observed: list[Detections], side: Side, *, metric: bool) -> Subject:
    """The person's hand from sightings.

    Raises:
        Refused: Too few of them show half of the landmarks, or they fit no human hand of this side.
    """
    points = [points_of(one, metric=metric) for one in observed if len(one)]
    positions = [np.where(one.measured[:, None], one.p_camera_m, np.nan) for one in points]
    protocol = bare_hand_protocol(metric=metric)
    p_m = np.array(positions, dtype=np.float64).reshape(len(positions), len(protocol.names), 3)
    series = LandmarkSeries(np.arange(len(p_m), dtype=np.float64), protocol.names, p_m)
    return calibrate_subject(series, protocol, side)


class BareHandTracker:
    """Fits one hand to its landmarks, capture after capture.

    Args:
        side: Side of the hand.
        metric: Whether the landmarks have the depth of a sensor.
        subject: The person, if known already; otherwise learnt from the first 60 sightings.
        doubt: Asked for what else is odd, such as a hand of the other side.
    """

    def __init__(
        self,
        side: Side,
        *,
        metric: bool,
        subject: Subject | None = None,
        doubt: Callable[[], str | None] | None = None,
    ) -> None:
        self._side: Side = side
        self._metric = metric
        self._protocol = bare_hand_protocol(metric=metric)
        self._doubt = doubt
        self._held: deque[Detections] = deque(maxlen=_HELD)
        self._subject = subject
        self._fitter = None if subject is None else PoseFitter(subject, self._protocol)
        self._last: tuple[int, HandFit] | None = None
        self._misses = 0
        self._trouble: str | None = None

    @property
    def state(self) -> TrackingState:
        """What it is doing."""
        if self._fitter is None:
            return "calibrating" if self._held and len(self._held[-1]) else "searching"
        return "tracking" if self._last is not None and self._misses <= _PATIENCE else "lost"

    @property
    def marker_names(self) -> tuple[str, ...]:
        """Names of the landmarks."""
        return self._protocol.names

    @property
    def subject(self) -> Subject | None:
        """The person, once learnt."""
        return self._subject

    @property
    def expected_m(self) -> Float64 | None:
        """None: the detector follows the hand in the image by itself."""
        return None

    @property
    def complaint(self) -> str | None:
        """What keeps the hand from being tracked, one sentence; None if nothing does."""
        return self._trouble or (self._doubt() if self._doubt is not None else None)

    def observe(self, detections: Detections) -> tuple[TrackedHand, ...]:
        """Take one capture; see ``Tracker.observe``."""
        if self._fitter is not None:
            return (self._track(self._fitter, detections),)
        self._held.append(detections)
        sightings = [one for one in self._held if len(one)]
        if len(sightings) < _LEARNT_FROM or not len(detections):
            return ()
        try:
            self._subject = learn_bare_hand(sightings, self._side, metric=self._metric)
        except Refused as refusal:
            # the next two seconds may show more; the reason is shown meanwhile
            self._trouble = str(refusal)
            self._held.clear()
            return ()
        self._trouble = None
        self._fitter = fitter = PoseFitter(self._subject, self._protocol)
        held = tuple(self._held)
        self._held.clear()
        return tuple(self._track(fitter, one) for one in held)

    def finish(self) -> tuple[TrackedHand, ...]:
        """What is still held back when no more captures come: nothing of it was understood."""
        rest = tuple(unknown(one.t_capture_ns, len(self.marker_names), self.state) for one in self._held)
        self._held.clear()
        return rest

    def _track(self, fitter: PoseFitter, detections: Detections) -> TrackedHand:
        if not len(detections):
            self._misses += 1
            state: TrackingState = "tracking" if self._misses <= _PATIENCE else "lost"
            return unknown(detections.t_capture_ns, len(self.marker_names), state)
        self._misses = 0
        t_ns = detections.t_capture_ns
        points = points_of(detections, metric=self._metric)
        fit = self._fitted(fitter, t_ns, points)
        self._last = (t_ns, fit)
        return _described(t_ns, points, fit)

    def _fitted(self, fitter: PoseFitter, t_ns: int, points: LandmarkPoints) -> HandFit:
        """The hand of one capture, from where it was; from nothing where that is long ago or fits badly."""
        p_m, sigma_m = points.p_camera_m[None], points.std_m[None]
        if self._last is not None and t_ns - self._last[0] <= _REMEMBERED_NS:
            before = self._last[1]
            std = np.full(before.joints_rad.shape, _EXPECTED_STD_RAD)
            fit = fitter.fit(p_m, sigma_m, before, JointPrior(before.joints_rad, std))
            if float(fit.residual_m[0]) < _DOUBTFUL_M:
                return fit
        return fitter.fit(p_m, sigma_m)


def _described(t_ns: int, points: LandmarkPoints, fit: HandFit) -> TrackedHand:
    """Records of one capture: what the picture shows is measured, what the network guessed estimated."""
    markers = MarkerFrame(
        t_ns=t_ns,
        p_camera_m=points.p_camera_m,
        covariance_m2=points.covariance_m2,
        status=np.where(points.measured, Status.MEASURED, Status.ESTIMATED).astype(np.uint8),
        pixel_px=points.pixel_px,
        similarity=points.similarity,
    )
    return TrackedHand(markers, pose_record(t_ns, fit, 0), points.row, "tracking")


__all__ = ["MEASURED", "PROTOCOL", "BareHandTracker", "bare_hand_protocol", "learn_bare_hand"]
