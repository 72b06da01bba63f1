"""From a fitted hand and its associated detections to the records of one capture."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.geometry.rotation import matrix_from_wxyz
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_fit import HandFit
from rehab_app.tracking.association import NONE
from rehab_app.tracking.moving_hand import marker_covariance
from rehab_app.tracking.tracked import TrackedHand, TrackingState
from sessions.records import HandPose, MarkerFrame, Status
from sessions.records.fields import Float64, Int64

_MODEL_STD_M = 0.0015  # of a marker's place on its bone: paper bends, skin slides


def described(model: MarkerModel, fit: HandFit, detections: Detections, match: Int64) -> TrackedHand:
    """Records of a capture whose hand was fitted: seen markers measured, all others estimated.

    Args:
        model: The person with the markers.
        fit: The hand, one frame.
        detections: What was seen.
        match: Detection of each marker, NONE where none, shape (M,).
    """
    seen = match != NONE
    rotation, joints = matrix_from_wxyz(fit.q_wxyz[0]), fit.joints_rad[0]
    expected = model.positions(joints) @ rotation.T + fit.p_palm_m[0]
    std = np.sqrt(np.maximum(np.diagonal(fit.joint_covariance_rad2[0]), 0.0))
    covariance = marker_covariance(model, joints, rotation, std) + _MODEL_STD_M**2 * np.eye(3)
    point = _laid(seen, match, detections.p_camera_m, expected)
    markers = MarkerFrame(
        t_ns=detections.t_capture_ns,
        p_camera_m=point,
        covariance_m2=_laid(seen, match, detections.covariance_m2, covariance),
        status=np.where(seen, Status.MEASURED, Status.ESTIMATED).astype(np.uint8),
        pixel_px=_laid(seen, match, detections.pixel_px, np.full((len(match), 2), np.nan)),
        similarity=_laid(seen, match, detections.similarity, np.zeros(len(match))),
    )
    pose = HandPose(
        t_ns=detections.t_capture_ns,
        p_camera_palm_m=fit.p_palm_m[0],
        q_camera_palm_wxyz=fit.q_wxyz[0],
        joints_rad=joints,
        joint_covariance_rad2=fit.joint_covariance_rad2[0],
        joint_status=fit.joint_status[0],
        fingertips_palm_m=fit.fingertips_palm_m[0],
        fingertip_covariance_m2=fit.fingertip_covariance_m2[0],
        residual_m=float(fit.residual_m[0]),
    )
    return TrackedHand(markers, pose, match, "tracking")


def unknown(t_ns: int, markers: int, state: TrackingState) -> TrackedHand:
    """Records of a capture of which nothing is known: every value a gap."""
    frame = MarkerFrame(
        t_ns=t_ns,
        p_camera_m=np.full((markers, 3), np.nan),
        covariance_m2=np.full((markers, 3, 3), np.nan),
        status=np.full(markers, Status.LOST, dtype=np.uint8),
        pixel_px=np.full((markers, 2), np.nan),
        similarity=np.zeros(markers),
    )
    pose = HandPose(
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
    return TrackedHand(frame, pose, np.full(markers, NONE, dtype=np.int64), state)


def _laid(
    seen: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], match: Int64, values: Float64, others: Float64
) -> Float64:
    """Values of the matched detections among those of unseen markers."""
    result = np.array(others, dtype=np.float64)
    result[seen] = values[match[seen]]
    return result
