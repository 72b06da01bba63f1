"""A computed grasp as a take: it is looked at, approved and played like any recorded movement."""

from __future__ import annotations

import uuid
from pathlib import Path

import numpy as np

from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.spiral import GraspPath
from rehab_app.grasp.target_json import StoredTarget, target_to_json
from rehab_app.grasp.timing import CLOSING_S, HOLD_S, there_and_back
from rehab_app.hand.pose_fit import HandFit
from rehab_app.hand.records import take_records
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject, subject_to_json
from rehab_app.recording.take import write_take
from robot_iface.kinematics import HandGeometry, forward, jacobian
from sessions.errors import Refused
from sessions.records import FINGERTIPS, JOINTS, LANDMARKS, Status
from sessions.records.fields import Float64
from sessions.records.header import SessionHeader
from sessions.store import SealedSession
from sessions.timebase import Timebase

SOURCE = "grasp"
"""What the header of such a take names as its source."""
_STEP_S = 0.02
_STD_RAD = 0.01  # computed, not measured: as sure as a well-seen joint, and marked ESTIMATED throughout


def write_grasp_take(
    path: Path,
    way: GraspPath,
    hand: GraspHand,
    *,
    exercise: str,
    software_version: str,
    target: StoredTarget | None = None,
    closing_s: float = CLOSING_S,
    hold_s: float = HOLD_S,
) -> SealedSession:
    """Write a take of one closing around the object and opening again.

    Args:
        path: Final name, ending in ``.mcap``; must not exist.
        way: From the open hand to the posture.
        hand: The person's hand that it was made for; its side is the take's.
        exercise: What is grasped, in words.
        software_version: Version of the application.
        target: What is grasped and how, for reviews; None keeps it to the words.
        closing_s: Time from open to the grasp; opening takes as long.
        hold_s: Time in the grasp.

    Raises:
        Refused: The hand is the robot's, a time is out of bounds, or the path cannot be written to.
    """
    geometry = hand.person
    if geometry is None:
        raise Refused(
            "take of a grasp", f"asked of the {hand.name}", "one of a person's hand", "use --hand human"
        )
    t_s, joints = there_and_back(way, closing_s, hold_s, _STEP_S)
    header = SessionHeader(
        session_id=uuid.uuid4().hex,
        kind="take",
        subject_id="",
        side=hand.side,
        exercise=exercise,
        source=SOURCE,
        software_version=software_version,
        utc_start_ns=Timebase.now().utc_start_ns,
        monotonic_start_ns=0,
        prescription="" if target is None else target_to_json(target),
        marker_protocol="",
        marker_names=(),
        subject_hand=subject_to_json(Subject(geometry, (), np.zeros((0, 3)))),
    )
    series = LandmarkSeries(t_s, (), np.zeros((t_s.size, 0, 3)))
    t_ns = np.round(1e9 * t_s).astype(np.int64)
    return write_take(path, header, take_records(t_ns, series, _known(geometry, joints)))


def _known(geometry: HandGeometry, joints_rad: Float64) -> HandFit:
    """The postures as if fitted, in the frame of the palm: nothing was seen, so everything is ESTIMATED."""
    frames = len(joints_rad)
    tips = [LANDMARKS.index(name) for name in FINGERTIPS]
    slopes = jacobian(geometry, joints_rad)[:, tips]
    covariance = np.tile(np.diag(np.full(len(JOINTS), _STD_RAD**2)), (frames, 1, 1))
    return HandFit(
        np.zeros((frames, 3)),
        np.tile([1.0, 0.0, 0.0, 0.0], (frames, 1)),
        joints_rad,
        covariance,
        np.full(joints_rad.shape, Status.ESTIMATED, dtype=np.uint8),
        forward(geometry, joints_rad).landmarks_m[:, tips],
        slopes @ covariance[:, None] @ np.swapaxes(slopes, -1, -2),
        np.full(frames, np.nan),
        np.ones(frames),
        np.zeros(0),
    )
