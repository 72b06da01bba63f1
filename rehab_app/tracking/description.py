"""From a tracked hand and the detections given to it to the records of one capture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.geometry.rotation import wxyz_from_matrix
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_prior import rest_prior
from rehab_app.hand.pose_uncertainty import JOINT_DIGIT, MEASURED_SHARE, MEASURED_STD_RAD
from rehab_app.hand.records import unknown_pose
from rehab_app.tracking.following import Followed
from rehab_app.tracking.hand_filter import Pairs, Placed, Rows, rows_of, trusted
from rehab_app.tracking.hand_state import POSITIONS, HandState
from rehab_app.tracking.sight import Sight
from rehab_app.tracking.tracked import TrackedHand, TrackingState
from sessions.records import HandPose, MarkerFrame, Status
from sessions.records.fields import Float64, Int64, UInt8

NONE = -1
_LEAST_M2 = 1e-12
_FORGOTTEN_S = 1.0  # a digit of which nothing was seen for so long is lost
_REST_STD_RAD = rest_prior(1).std_rad
_LOOSE = np.diag(np.concatenate([np.full(6, 1e-2), 1.0 / _REST_STD_RAD**2]))
_ALMOST_MEASURED = np.minimum(MEASURED_STD_RAD, MEASURED_SHARE * _REST_STD_RAD)


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What a description needs beside the hand and the detections.

    Attributes:
        model: The person with the markers.
        wobble_m2: Variance of a marker's place on its bone, per axis.
        unseen_s: How long nothing was seen of each digit and, last, of the palm, shape (6,).
        floor_rad2: Covariance of the joints that comes of not knowing the hand exactly, shape (21, 21).
    """

    model: MarkerModel
    wobble_m2: float
    unseen_s: Float64
    floor_rad2: Float64


def described(found: Followed, sight: Sight, known: Knowledge) -> TrackedHand:
    """Records of a capture: given detections measured, all else estimated, what was long unseen lost."""
    state, pairs, after = found.state, found.pairs, found.after
    rows = rows_of(after, sight, pairs, known.wobble_m2)
    detection = np.full(len(after.p_m), NONE, dtype=np.int64)
    detection[pairs.marker[::-1]] = pairs.row[::-1]
    markers = _markers(state, after, rows, sight, pairs, known, detection)
    return TrackedHand(markers, _pose(state, rows, known, pairs), detection, "tracking")


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
    return TrackedHand(frame, unknown_pose(t_ns), np.full(markers, NONE, dtype=np.int64), state)


def _markers(
    state: HandState,
    after: Placed,
    rows: Rows,
    sight: Sight,
    pairs: Pairs,
    known: Knowledge,
    detection: Int64,
) -> MarkerFrame:
    """The markers: between the fitted hand and the detection, by what either is worth."""
    point, covariance = _between(state, after, rows, sight, pairs, known.wobble_m2)
    seen = detection != NONE
    forgotten = ~seen & (known.unseen_s[known.model.digit] > _FORGOTTEN_S)
    point[forgotten], covariance[forgotten] = np.nan, np.nan
    status = np.where(seen, Status.MEASURED, np.where(forgotten, Status.LOST, Status.ESTIMATED))
    found = sight.detections.rows(detection[seen])
    pixel, similarity = np.full((len(point), 2), np.nan), np.zeros(len(point))
    pixel[seen], similarity[seen] = found.pixel_px, found.similarity
    return MarkerFrame(
        t_ns=state.t_ns,
        p_camera_m=point,
        covariance_m2=covariance,
        status=status.astype(np.uint8),
        pixel_px=pixel,
        similarity=similarity,
    )


def _between(
    state: HandState, after: Placed, rows: Rows, sight: Sight, pairs: Pairs, wobble_m2: float
) -> tuple[Float64, Float64]:
    """Places (M, 3) between the hand's and those seen, and their covariance (M, 3, 3)."""
    axes = sight.axes[pairs.row]
    weight = np.where(trusted(rows), 1.0 / np.maximum(rows.variance_m2 - wobble_m2, _LEAST_M2), 0.0)
    told = np.swapaxes(axes, 1, 2) * weight[:, None]
    information = np.tile(np.eye(3) / wobble_m2, (len(after.p_m), 1, 1))
    np.add.at(information, pairs.marker, told @ axes)
    pull = np.zeros_like(after.p_m)
    np.add.at(pull, pairs.marker, (told @ rows.residual_m[..., None])[..., 0])
    beside: Float64 = np.asarray(np.linalg.inv(information), dtype=np.float64)
    covariance = after.covariance_m2(state.position_covariance) + beside
    covariance = 0.5 * (covariance + np.swapaxes(covariance, 1, 2))
    return after.p_m + (beside @ pull[..., None])[..., 0], covariance


def _pose(state: HandState, rows: Rows, known: Knowledge, pairs: Pairs) -> HandPose:
    covariance = state.joint_covariance_rad2 + known.floor_rad2
    tips, slopes = known.model.fingertips(known.model.place(state.joints_rad))
    tip_covariance = slopes @ covariance @ np.swapaxes(slopes, 1, 2)
    status = _joint_status(rows, known, pairs)
    lost = status == Status.LOST
    lost_tip = np.array([bool(lost[JOINT_DIGIT == digit].any()) for digit in range(5)])
    covariance[lost[:, None] | lost] = np.nan
    tips[lost_tip], tip_covariance[lost_tip] = np.nan, np.nan
    used = trusted(rows)
    square = float((rows.residual_m**2 * used).sum())
    return HandPose(
        t_ns=state.t_ns,
        p_camera_palm_m=state.p_m,
        q_camera_palm_wxyz=wxyz_from_matrix(state.rotation),
        joints_rad=np.where(lost, np.nan, state.joints_rad),
        joint_covariance_rad2=covariance,
        joint_status=status,
        fingertips_palm_m=tips,
        fingertip_covariance_m2=tip_covariance,
        residual_m=float(np.sqrt(square / len(pairs))) if len(pairs) else float("nan"),
    )


def _joint_status(rows: Rows, known: Knowledge, pairs: Pairs) -> UInt8:
    """Measured where this capture alone, with the palm's help, fixes a joint; the rule of the batch fit."""
    weight = trusted(rows) / rows.variance_m2
    flat = rows.slopes.reshape(-1, POSITIONS)
    alone = np.linalg.inv(flat.T @ (weight.reshape(-1, 1) * flat) + _LOOSE)
    fixed = np.sqrt(np.diagonal(alone)[6:]) < _ALMOST_MEASURED
    seen = np.isin(np.arange(5), known.model.digit[pairs.marker])[JOINT_DIGIT]
    forgotten = known.unseen_s[JOINT_DIGIT] > _FORGOTTEN_S
    status = np.where(forgotten, Status.LOST, Status.ESTIMATED)
    return np.where(fixed & seen, Status.MEASURED, status).astype(np.uint8)
