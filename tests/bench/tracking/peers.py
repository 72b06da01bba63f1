"""Trackers to compare with: independent markers with Kalman filters, and perfect association as the limit.

All are given the names of frame 0 and follow a fixed set of markers, as ours do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import linear_sum_assignment

from rehab_app.cameras.sequence import PointSequence
from rehab_app.geometry.detections import Detections
from sessions.records.fields import Float64, Int64
from tests.bench.tracking.score import Tracks

_DAMPING = 0.9  # undamped constant velocity diverges while coasting
_GATE_2 = 13.8  # 99.9 % of chi-square with 2 degrees of freedom
_GATE_3 = 16.3


Points = Callable[[Detections, "KalmanBank"], Float64]
Project = Callable[[Float64], Float64]


class KalmanBank:
    """One damped constant-velocity Kalman filter per marker, over d coordinates, in steps of one frame.

    Args:
        start: First positions, shape (M, d).
        acceleration: Standard deviation of the change of speed in one frame.
        noise: Standard deviation of a measurement.
    """

    def __init__(self, start: Float64, acceleration: float, noise: float) -> None:
        markers, size = start.shape
        eye, zero = np.eye(size), np.zeros((size, size))
        self._move = np.block([[eye, eye], [zero, _DAMPING * eye]])
        self._drift = acceleration**2 * np.block([[0.25 * eye, 0.5 * eye], [0.5 * eye, eye]])
        self._noise = noise**2 * eye
        self.mean = np.concatenate([start, np.zeros_like(start)], axis=1)
        spread = np.block([[self._noise, zero], [zero, (2.0 * acceleration) ** 2 * eye]])
        self.covariance = np.tile(spread, (markers, 1, 1))
        self._size = size

    @property
    def place(self) -> Float64:
        """Positions, shape (M, d)."""
        return self.mean[:, : self._size]

    def predict(self, steps: int) -> None:
        """Go on by some frames."""
        for _ in range(steps):
            self.mean = self.mean @ self._move.T
            self.covariance = self._move @ self.covariance @ self._move.T + self._drift

    def distances(self, seen: Float64) -> Float64:
        """Squared Mahalanobis distance of every pair, shape (M, D)."""
        total = self.covariance[:, : self._size, : self._size] + self._noise
        apart = seen[None] - self.place[:, None]
        return np.einsum("mdi,mij,mdj->md", apart, np.linalg.inv(total), apart)

    def update(self, marker: Int64, seen: Float64) -> None:
        """Take the measurements (K, d) of some markers (K,)."""
        covariance = self.covariance[marker]
        total = covariance[:, : self._size, : self._size] + self._noise
        gain = covariance[:, :, : self._size] @ np.linalg.inv(total)
        self.mean[marker] += np.einsum("kij,kj->ki", gain, seen - self.place[marker])
        self.covariance[marker] = covariance - gain @ covariance[:, : self._size]


def hungarian_2d(sequence: PointSequence) -> Tracks:
    """Hungarian assignment and Kalman filters in the image."""
    bank = KalmanBank(sequence.init_pixel_px, 2.0, 1.0)
    return _follow(sequence, bank, _GATE_2, lambda one, _: one.pixel_px, lambda place: place)


def hungarian_3d(sequence: PointSequence, acceleration_m: float = 0.002) -> Tracks:
    """Hungarian assignment and Kalman filters in space; a blob without depth is put at the hand's."""
    first = sequence.detections[0]
    apart = np.linalg.norm(sequence.init_pixel_px[:, None] - first.pixel_px, axis=2)
    depth = float(np.nanmedian(first.p_camera_m[apart.argmin(axis=1), 2]))
    start = sequence.intrinsics.lift(sequence.init_pixel_px, np.full(len(apart), depth))
    near = np.where(apart.min(axis=1) < 8.0, apart.argmin(axis=1), -1)
    good = (near >= 0) & np.isfinite(first.p_camera_m[near, 2])
    start[good] = first.p_camera_m[near[good]]
    bank = KalmanBank(start, acceleration_m, 0.003)

    def points(one: Detections, bank: KalmanBank) -> Float64:
        middle = float(np.median(bank.place[:, 2]))
        filled = sequence.intrinsics.lift(one.pixel_px, np.full(len(one), middle))
        return np.where(np.isfinite(one.p_camera_m), one.p_camera_m, filled)

    return _follow(sequence, bank, _GATE_3, points, sequence.intrinsics.project)


def _follow(
    sequence: PointSequence, bank: KalmanBank, gate: float, points: Points, project: Project
) -> Tracks:
    frames, markers = sequence.visible.shape
    said = np.full((frames, markers, 2), np.nan)
    detection = np.full((frames, markers), -1, dtype=np.int64)
    before = 0
    for frame, one in sequence.received():
        bank.predict(frame - before)
        before = frame
        seen = points(one, bank)
        square = bank.distances(seen)
        rows, columns = linear_sum_assignment(np.minimum(square, gate))
        kept = square[rows, columns] < gate
        bank.update(rows[kept], seen[columns[kept]])
        detection[frame, rows[kept]] = columns[kept]
        said[frame] = project(bank.place)
    return Tracks(said, detection)


def oracle(sequence: PointSequence) -> Tracks:
    """Perfect association of what was detected; a marker without a detection stays where it was last."""
    frames, markers = sequence.visible.shape
    said = np.full((frames, markers, 2), np.nan)
    detection = np.full((frames, markers), -1, dtype=np.int64)
    last = sequence.init_pixel_px.copy()
    for frame, one in sequence.received():
        owner, other = sequence.owner[frame], sequence.other[frame]
        for marker, row in [
            *zip(other, range(len(one)), strict=True),
            *zip(owner, range(len(one)), strict=True),
        ]:
            if marker >= 0:
                detection[frame, marker], last[marker] = row, one.pixel_px[row]
        said[frame] = last
    return Tracks(said, detection)
