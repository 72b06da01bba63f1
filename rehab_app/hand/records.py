"""A fit and the markers behind it as records of a session file."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rehab_app.hand.pose_fit import HandFit
from rehab_app.hand.series import LandmarkSeries
from sessions.records import HandPose, MarkerFrame, Status
from sessions.records.fields import Int64


def pose_record(t_ns: int, fit: HandFit, row: int) -> HandPose:
    """One frame of a fit as a record."""
    return HandPose(
        t_ns=t_ns,
        p_camera_palm_m=fit.p_palm_m[row],
        q_camera_palm_wxyz=fit.q_wxyz[row],
        joints_rad=fit.joints_rad[row],
        joint_covariance_rad2=fit.joint_covariance_rad2[row],
        joint_status=fit.joint_status[row],
        fingertips_palm_m=fit.fingertips_palm_m[row],
        fingertip_covariance_m2=fit.fingertip_covariance_m2[row],
        residual_m=float(fit.residual_m[row]),
    )


def unknown_pose(t_ns: int) -> HandPose:
    """A hand of which nothing is known: every value a gap."""
    return HandPose(
        t_ns=t_ns,
        p_camera_palm_m=np.full(3, np.nan),
        q_camera_palm_wxyz=np.full(4, np.nan),
        joints_rad=np.full(21, np.nan),
        joint_covariance_rad2=np.full((21, 21), np.nan),
        joint_status=np.full(21, Status.LOST, dtype=np.uint8),
        fingertips_palm_m=np.full((5, 3), np.nan),
        fingertip_covariance_m2=np.full((5, 3, 3), np.nan),
        residual_m=float("nan"),
    )


def take_records(t_ns: Int64, series: LandmarkSeries, fit: HandFit) -> Iterator[tuple[MarkerFrame, HandPose]]:
    """Markers and poses of a whole recording, frame by frame; unseen markers are NaN and LOST.

    Args:
        t_ns: Capture times, monotonic, shape (N,).
        series: Markers of the N frames.
        fit: The hand fitted to them, with noise estimated per marker.
    """
    seen = series.seen
    status = np.where(seen, int(Status.MEASURED), int(Status.LOST)).astype(np.uint8)
    positions = np.where(seen[..., None], series.p_camera_m, np.nan)
    covariance = fit.noise_m[:, None, None] ** 2 * np.eye(3)
    no_pixel = np.full((len(series.names), 2), np.nan)
    for row in range(len(t_ns)):
        markers = MarkerFrame(
            t_ns=int(t_ns[row]),
            p_camera_m=positions[row],
            covariance_m2=np.where(seen[row, :, None, None], covariance, np.nan),
            status=status[row],
            pixel_px=no_pixel,
            similarity=seen[row].astype(np.float64),
        )
        yield markers, pose_record(int(t_ns[row]), fit, row)
