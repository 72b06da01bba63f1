"""The kinematic tracker: a hand model predicts, detections are associated with it, the hand is fitted.

For each capture: predict pose and joints by damped constant velocity; take the pairs of marker and detection
that are beyond doubt; fit; associate the rest against the now smaller uncertainty; fit again. What is not
seen stays an estimate of the model. After a loss, the hand as it was last and as an open hand are looked for.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.pose_fit import HandFit, PoseFitter
from rehab_app.hand.pose_prior import JointPrior
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from rehab_app.tracking.association import NONE, best_pairs, clear_pairs, distances, facing_penalty
from rehab_app.tracking.description import described, unknown
from rehab_app.tracking.labelling import label_open_hand
from rehab_app.tracking.moving_hand import Expectation, MovingHand, at_rest, expect, followed
from rehab_app.tracking.open_hand import OpenHand, open_shapes
from rehab_app.tracking.tracked import TrackedHand, TrackingState
from sessions.records import Side
from sessions.records.fields import Float64, Int64

_MODEL_STD_M = 0.0008
_FEWEST = 4  # markers without which a capture says too little of where the hand is
_PATIENCE = 10  # captures without them before the hand counts as lost
_HELD = 450  # captures kept back at most while the hand is learnt; the oldest are given up


class KinematicTracker:
    """Tracks one hand that wears a protocol's markers.

    Args:
        protocol: The markers.
        side: Side of the hand; never inferred.
        subject: The person, if known already; otherwise learnt from the open hand of the first second.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side, subject: Subject | None = None) -> None:
        self._protocol = protocol
        self._open_hand = OpenHand(protocol, side)
        self._held: deque[Detections] = deque(maxlen=_HELD)
        self._fitter = None if subject is None else PoseFitter(subject, protocol)
        self._subject = subject
        self._last: MovingHand | None = None
        self._misses = 0
        self._expectation: Float64 | None = None

    @property
    def state(self) -> TrackingState:
        """What it is doing."""
        if self._fitter is None:
            return "calibrating" if self._open_hand.found else "searching"
        return "tracking" if self._last is not None and self._misses <= _PATIENCE else "lost"

    @property
    def marker_names(self) -> tuple[str, ...]:
        """Names of the markers."""
        return self._protocol.names

    @property
    def subject(self) -> Subject | None:
        """The person, once calibrated."""
        return self._subject

    @property
    def expected_m(self) -> Float64 | None:
        """Where to look next, shape (K, 3); None for everywhere."""
        if self._fitter is None:
            return self._open_hand.expected_m
        return self._expectation if self.state == "tracking" and self._misses == 0 else None

    def observe(self, detections: Detections) -> tuple[TrackedHand, ...]:
        """Take one capture; see ``Tracker.observe``."""
        if self._fitter is not None:
            return (self._track(self._fitter, detections),)
        self._held.append(detections)
        subject = self._open_hand.feed(detections)
        if subject is None:
            return ()
        return self._learnt(subject)

    def _learnt(self, subject: Subject) -> tuple[TrackedHand, ...]:
        """Track all that was held back, from the first capture of the open hand on."""
        self._subject = subject
        self._fitter = PoseFitter(subject, self._protocol)
        start_ns, points = self._open_hand.labelled[0]
        self._last = at_rest(start_ns, self._fitter.fit(points[None], self._noise()))
        held = tuple(self._held)
        self._held.clear()
        lost = [one.t_capture_ns for one in held if one.t_capture_ns < start_ns]
        before = tuple(unknown(t_ns, len(self.marker_names), "searching") for t_ns in lost)
        fitter = self._fitter
        return before + tuple(self._track(fitter, one) for one in held if one.t_capture_ns >= start_ns)

    def _noise(self) -> Float64:
        return np.full(len(self.marker_names), self._protocol.noise_m)

    def _track(self, fitter: PoseFitter, detections: Detections) -> TrackedHand:
        last = self._last if self._last is not None and self._misses <= _PATIENCE else None
        found = self._follow(fitter, last, detections) if last else self._regain(fitter, detections)
        if found is None:
            self._misses += 1
            state: TrackingState = "tracking" if self._misses <= _PATIENCE else "lost"
            return unknown(detections.t_capture_ns, len(self.marker_names), state)
        fit, match = found
        t_ns = detections.t_capture_ns
        moved = last is not None and t_ns > last.t_ns
        self._last = followed(last, t_ns, fit) if last is not None and moved else at_rest(t_ns, fit)
        self._misses = 0
        tracked = described(fitter.model, fit, detections, match)
        self._expectation = tracked.markers.p_camera_m
        return tracked

    def _follow(
        self, fitter: PoseFitter, last: MovingHand, detections: Detections
    ) -> tuple[HandFit, Int64] | None:
        """The hand near where it is expected, and its detections; None if too little is seen of it."""
        expected = expect(fitter.model, last, detections.t_capture_ns)
        cost = _costs(expected, detections)
        match = clear_pairs(cost)
        if int((match != NONE).sum()) < _FEWEST:
            match = best_pairs(cost)
        if int((match != NONE).sum()) < _FEWEST:
            return None
        fit = _fitted(fitter, expected.start, expected.prior, detections, match)
        if _all_told(cost, match):
            return fit, match
        near = expect(fitter.model, at_rest(detections.t_capture_ns, fit), detections.t_capture_ns)
        match = best_pairs(_costs(near, detections))
        if int((match != NONE).sum()) < _FEWEST:
            return None
        return _fitted(fitter, fit, expected.prior, detections, match), match

    def _regain(self, fitter: PoseFitter, detections: Detections) -> tuple[HandFit, Int64] | None:
        """Find the lost hand again, open or as it was last; None where there is none."""
        shapes = open_shapes(fitter.model)
        if self._last is not None:
            shapes = np.concatenate([fitter.model.positions(self._last.fit.joints_rad), shapes])
        missing = len(self.marker_names) // 4
        found = label_open_hand(detections.p_camera_m, shapes, gate_m=0.02, missing=missing)
        if found is None or found.residual_m > 0.008:
            return None
        points = np.where((found.detection != NONE)[:, None], detections.p_camera_m[found.detection], np.nan)
        start = fitter.fit(points[None], self._noise())
        return self._follow(fitter, at_rest(detections.t_capture_ns, start), detections)


def _costs(expected: Expectation, detections: Detections) -> Float64:
    """Cost of every pair of marker and detection, shape (M, D)."""
    cost = distances(
        expected.p_camera_m, expected.covariance_m2, detections.p_camera_m, detections.covariance_m2
    )
    return cost + facing_penalty(expected.normal_camera, expected.p_camera_m)[:, None]


def _all_told(cost: Float64, match: Int64) -> bool:
    """Whether no marker that lacks a detection could still take one that is free."""
    free = np.setdiff1d(np.arange(cost.shape[1]), match)
    return not bool((cost[np.ix_(match == NONE, free)] < 1e5).any())


def _fitted(
    fitter: PoseFitter, start: HandFit, prior: JointPrior, detections: Detections, match: Int64
) -> HandFit:
    """The hand fitted to the matched detections, one frame."""
    seen = match != NONE
    points = np.where(seen[:, None], detections.p_camera_m[match], np.nan)
    variance = np.diagonal(detections.covariance_m2, axis1=1, axis2=2)[match] + _MODEL_STD_M**2
    sigma = np.where(seen[:, None], np.sqrt(variance), 1.0)
    return fitter.fit(points[None], sigma[None], start, prior)
