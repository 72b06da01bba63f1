"""Markers followed in the image by the association filter, and their places in space by depth."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.tracking.rbmcda_depth import DepthMemory, pinhole_of
from rehab_app.tracking.rbmcda_filter import Association, RbmcdaFilter
from rehab_app.tracking.rbmcda_particles import CLUTTER
from rehab_app.tracking.rbmcda_settings import RbmcdaSettings
from sessions.records import MarkerFrame, Status
from sessions.records.fields import Float64, Int64

_LOST_AFTER_NS = 500_000_000  # a marker unseen for longer is no estimate any more
_STRAY_PX = 2.0  # an unseen marker of a moving hand may stray so far in a period; the filter does not say
_NEVER = np.iinfo(np.int64).min // 2
_PERIODS = (0.1, 60.0)  # bounds of the time between captures that the filter is told


class ImageTracks:
    """The markers of one hand in one image.

    Args:
        settings: Of the filter.
        markers: How many there are.
        seed: Of its draws.

    Attributes:
        filter: The filter in the image.
        detection: Row of the detection of each marker in the last capture, CLUTTER where none, shape (M,).
        pinhole: The camera, once enough was seen to tell it.
    """

    def __init__(self, settings: RbmcdaSettings, markers: int, seed: int) -> None:
        self.filter = RbmcdaFilter(settings, markers, np.random.default_rng(seed))
        self.detection: Int64 = np.full(markers, CLUTTER, dtype=np.int64)
        self.pinhole: Intrinsics | None = None
        self._settings = settings
        self._depth = DepthMemory(markers)
        self._seen_ns: Int64 = np.full(markers, _NEVER, dtype=np.int64)
        self._last_ns: int | None = None

    @property
    def known(self) -> Int64:
        """Markers that were ever placed, rising."""
        return np.flatnonzero(self.filter.particles.active)

    @property
    def never_seen(self) -> Int64:
        """Markers that never had a detection, rising."""
        return np.flatnonzero(self._seen_ns == _NEVER)

    @property
    def any_lost(self) -> bool:
        """Whether a marker was unseen for too long in the last capture, or was never placed."""
        return self._last_ns is not None and bool((self._last_ns - self._seen_ns > _LOST_AFTER_NS).any())

    def place(self, markers: Int64, pixel_px: Float64, std_px: float | None = None) -> None:
        """Begin, or begin again, with markers (K,) at pixels (K, 2)."""
        std_px = self._settings.measurement_std_px if std_px is None else std_px
        self.filter.particles.place(markers, pixel_px, std_px)

    def restart(self) -> None:
        """The hand has come back somewhere else: no marker is known, no depth is remembered."""
        self.filter.particles.active[:] = False
        self._depth.forget()

    def follow(self, detections: Detections) -> MarkerFrame:
        """Take the detections of one capture, all of the tracking camera."""
        t_ns = detections.t_capture_ns
        elapsed_s = self._settings.period_s if self._last_ns is None else 1e-9 * (t_ns - self._last_ns)
        self._last_ns = t_ns
        self.pinhole = self.pinhole or pinhole_of(detections, self._settings.image_px)
        association = self.filter.step(
            detections.pixel_px, float(np.clip(elapsed_s / self._settings.period_s, *_PERIODS))
        )
        self.detection = association.detection
        seen = np.flatnonzero(self.detection != CLUTTER)
        self._seen_ns[seen] = t_ns
        return self._record(detections, association, seen, 30.0 * elapsed_s)

    def _record(
        self, detections: Detections, association: Association, seen: Int64, periods: float
    ) -> MarkerFrame:
        t_ns, markers = detections.t_capture_ns, len(self.detection)
        rows = self.detection[seen]
        lost = (t_ns - self._seen_ns > _LOST_AFTER_NS) | ~self.filter.particles.active
        pixel = np.where(lost[:, None], np.nan, association.pixel_px)
        pixel[seen] = detections.pixel_px[rows]
        similarity = np.zeros(markers)
        similarity[seen] = detections.similarity[rows]
        status = np.where(lost, Status.LOST, Status.ESTIMATED).astype(np.uint8)
        status[seen] = Status.MEASURED
        good = self._depth.credible(seen, detections.p_camera_m[rows, 2], periods)
        std = np.sqrt(detections.covariance_m2[rows[good], 2, 2])
        self._depth.remember(seen[good], detections.p_camera_m[rows[good], 2], std)
        unseen = np.where(lost, 0.0, 1e-9 * (t_ns - self._seen_ns) / self._settings.period_s)
        point, covariance = self._lifted(pixel, np.hypot(association.std_px, _STRAY_PX * unseen))
        point[seen[good]] = detections.p_camera_m[rows[good]]
        covariance[seen[good]] = detections.covariance_m2[rows[good]]
        return MarkerFrame(
            t_ns=t_ns,
            p_camera_m=point,
            covariance_m2=covariance,
            status=status,
            pixel_px=pixel,
            similarity=similarity,
        )

    def _lifted(self, pixel_px: Float64, std_px: Float64) -> tuple[Float64, Float64]:
        """Points (M, 3) and covariances (M, 3, 3) of pixels at the depths that are remembered, else NaN."""
        if self.pinhole is None:
            return np.full((len(pixel_px), 3), np.nan), np.full((len(pixel_px), 3, 3), np.nan)
        depth = self._depth
        point = self.pinhole.lift(pixel_px, depth.depth_m)
        covariance = self.pinhole.lift_covariance(pixel_px, depth.depth_m, std_px, depth.std_m)
        gone = ~np.isfinite(point).all(axis=1)
        point[gone], covariance[gone] = np.nan, np.nan
        return point, covariance
