"""The hand behind tracked markers: the person learnt from the first of them, then a pose for each capture."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from rehab_app.geometry.rotation import matrix_from_wxyz
from rehab_app.hand.calibration import calibrate_subject
from rehab_app.hand.pose_fit import HandFit, PoseFitter
from rehab_app.hand.pose_prior import JointPrior
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.records import pose_record, unknown_pose
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject
from rehab_app.tracking.tracked import TrackedHand
from sessions.errors import Refused
from sessions.records import JOINTS, HandPose, MarkerFrame, Side, Status
from sessions.records.fields import Float64

LEARNT_FROM = 20
"""Captures that the person is learnt from."""
_MEANS = 5
_SHARE_SEEN = 0.5  # of the markers, without which a capture teaches nothing
_AGAIN = 30  # captures until the next attempt after one that failed
_FEWEST = 4
_WEAK_STD_RAD = 0.35  # how far the last capture's joints are trusted to be those of this one
_UNFIT_M = 0.03  # markers that lie farther from any hand than this carry each other's names
_MODEL_STD_M = 0.0015


class HandBehind:
    """Fits a hand to the markers of each capture; they do not learn of it.

    Args:
        protocol: The markers.
        side: Side of the hand.
        subject: The person, if known.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side, subject: Subject | None) -> None:
        self._protocol = protocol
        self._side: Side = side
        self._seen: deque[tuple[int, Float64]] = deque(maxlen=LEARNT_FROM)
        self._patience = LEARNT_FROM
        self._last: HandFit | None = None
        self.subject: Subject | None = None
        self.fitter: PoseFitter | None = None
        if subject is not None:
            self.know(subject)

    def know(self, subject: Subject) -> None:
        """This is the person."""
        self.subject, self.fitter = subject, PoseFitter(subject, self._protocol)
        self._seen.clear()

    @property
    def joints_rad(self) -> Float64 | None:
        """Joints of the last hand that was fitted, shape (21,)."""
        return None if self._last is None else self._last.joints_rad[0]

    @property
    def expected_m(self) -> Float64 | None:
        """Every marker on the last hand that was fitted, camera frame, shape (M, 3)."""
        if self._last is None or self.fitter is None:
            return None
        turn, joints = matrix_from_wxyz(self._last.q_wxyz[0]), self._last.joints_rad[0]
        if not bool(np.isfinite(joints).all()):
            return None
        return self.fitter.model.positions(joints) @ turn.T + self._last.p_palm_m[0]

    def learn(self, markers: MarkerFrame) -> None:
        """Take a capture while the person is unknown; of enough captures, know the person."""
        p_camera_m = measured(markers)
        if self.fitter is not None or np.isfinite(p_camera_m[:, 0]).mean() < _SHARE_SEEN:
            return
        self._seen.append((markers.t_ns, p_camera_m))
        self._patience -= 1
        if self._patience > 0:
            return
        try:
            self.know(calibrate_subject(self._means(), self._protocol, self._side))
        except Refused:
            self._patience = _AGAIN

    def _means(self) -> LandmarkSeries:
        """Means over a few captures each: they tell as much of a hand that moves little, and sooner."""
        points = np.array([p_m for _, p_m in self._seen]).reshape(_MEANS, -1, len(self._protocol.names), 3)
        times = 1e-9 * np.array([t_ns - self._seen[0][0] for t_ns, _ in self._seen]).reshape(_MEANS, -1)
        seen = np.isfinite(points)
        count = np.where(seen.any(axis=1), seen.sum(axis=1), np.nan)
        mean = np.where(seen, points, 0.0).sum(axis=1) / count
        return LandmarkSeries(times.mean(axis=1), self._protocol.names, mean)

    def pose(self, markers: MarkerFrame) -> HandPose:
        """The hand fitted to the measured markers of a capture; gaps if they are too few or no hand's."""
        fit = self._fitted(measured(markers), markers.covariance_m2)
        if fit is None or not fit.residual_m[0] < _UNFIT_M:
            return unknown_pose(markers.t_ns)
        self._last = fit
        return pose_record(markers.t_ns, fit, 0)

    def _fitted(self, p_camera_m: Float64, covariance_m2: Float64) -> HandFit | None:
        seen = np.isfinite(p_camera_m[:, 0])
        if self.fitter is None or int(seen.sum()) < _FEWEST:
            return None
        variance = np.diagonal(covariance_m2, axis1=1, axis2=2) + _MODEL_STD_M**2
        sigma = np.where(seen[:, None], np.sqrt(variance), 1.0)
        prior = None
        if self._last is not None and bool(np.isfinite(self._last.joints_rad).all()):
            prior = JointPrior(self._last.joints_rad, np.full(len(JOINTS), _WEAK_STD_RAD))
        return self.fitter.fit(p_camera_m[None], sigma[None], self._last, prior)


def measured(markers: MarkerFrame) -> Float64:
    """Points of the markers that were seen, NaN for others, shape (M, 3)."""
    return np.where((markers.status == Status.MEASURED)[:, None], markers.p_camera_m, np.nan)


def posed(hand: HandBehind, tracked: TrackedHand) -> TrackedHand:
    """A capture that was tracked before the person was known, now with its pose."""
    return replace(tracked, pose=hand.pose(tracked.markers))
