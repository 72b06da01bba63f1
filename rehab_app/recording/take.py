"""The one way to turn markers and hand poses into a take file, and a take file into a motion."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from rehab_app.hand.subject import geometry_from_json
from robot_iface.kinematics import HandGeometry, forward
from sessions.errors import Refused
from sessions.records import (
    JOINTS,
    LANDMARKS,
    Event,
    HandPose,
    JointStates,
    MarkerFrame,
    Side,
    Topic,
    Transforms,
)
from sessions.records.fields import Float64, Int64, UInt8
from sessions.records.header import SessionHeader
from sessions.records.topics import EVENTS, HAND_JOINTS, HAND_POSE, MARKERS, TRANSFORMS
from sessions.store import SealedSession, SessionReader, SessionWriter

SHORTEST_S = 1.0
"""A take is at least this long."""
SPACE = "reference"
"""Prefix of the frames of a therapist's hand."""

_VIEWER_PERIOD_NS = 33_000_000  # strangers' viewers get 30 Hz at most
_UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])


class TakeRecorder:
    """Writes one take, frame by frame; a context manager that leaves a recoverable file if it is not sealed.

    Args:
        path: Final name, ending in ``.mcap``; must not exist.
        header: Of kind "take", with the subject's hand and the marker names.

    Raises:
        Refused: The path cannot be written to, or the header states no hand.
    """

    def __init__(self, path: Path, header: SessionHeader, shortest_s: float = SHORTEST_S) -> None:
        self.geometry = geometry_from_json(header.subject_hand)
        self._shortest_s = shortest_s
        self._writer = SessionWriter(path, header)
        self._first_ns: int | None = None
        self._last_ns = 0
        self._viewed_ns: int | None = None

    def __enter__(self) -> TakeRecorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._writer.close()

    @property
    def duration_s(self) -> float:
        """Time from the first to the last frame so far, s."""
        return 0.0 if self._first_ns is None else 1e-9 * (self._last_ns - self._first_ns)

    def add(self, markers: MarkerFrame, pose: HandPose) -> None:
        """Append one capture. Its times are equal and later than those before.

        Raises:
            Refused: The times do not rise, or the disk is full.
        """
        if pose.t_ns != markers.t_ns or (self._first_ns is not None and pose.t_ns <= self._last_ns):
            raise Refused(
                "capture time", f"{pose.t_ns} ns", "rising, one for markers and pose", "mend the camera"
            )
        self._first_ns = pose.t_ns if self._first_ns is None else self._first_ns
        self._last_ns = pose.t_ns
        self._writer.write(MARKERS, markers)
        self._writer.write(HAND_POSE, pose)
        if self._viewed_ns is None or pose.t_ns - self._viewed_ns >= _VIEWER_PERIOD_NS:
            self._viewed_ns = pose.t_ns
            self._write_for_viewers(pose)

    def note(self, event: Event) -> None:
        """Append an event."""
        self._writer.write(EVENTS, event)

    def write(self, records: Iterable[tuple[Topic, Any]]) -> None:
        """Append other records, such as images.

        Raises:
            Refused: The header states no consent to images, or the disk is full.
        """
        for topic, record in records:
            self._writer.write(topic, record)

    def attach(self, name: str, texts: dict[str, str]) -> None:
        """Add a metadata record, such as how the take was retouched."""
        self._writer.attach_metadata(name, texts)

    def seal(self) -> SealedSession:
        """Finish the take.

        Raises:
            Refused: It is too short: nothing is left of it then. Or the disk is full.
        """
        if self.duration_s < self._shortest_s:
            self.discard()
            raise too_short(self.duration_s, self._shortest_s)
        return self._writer.seal()

    def discard(self) -> None:
        """Close and remove what was written; a sealed take stays."""
        self._writer.close()
        self._writer.partial.unlink(missing_ok=True)

    def _write_for_viewers(self, pose: HandPose) -> None:
        known = np.flatnonzero(np.isfinite(pose.joints_rad))
        if known.size:
            names = tuple(JOINTS[index] for index in known)
            self._writer.write(
                HAND_JOINTS, JointStates(t_ns=pose.t_ns, names=names, positions_rad=pose.joints_rad[known])
            )
        if np.isfinite(pose.p_camera_palm_m).all():
            self._writer.write(TRANSFORMS, hand_transforms(self.geometry, pose))


def write_take(
    path: Path,
    header: SessionHeader,
    frames: Iterable[tuple[MarkerFrame, HandPose]],
    shortest_s: float = SHORTEST_S,
) -> SealedSession:
    """Write a whole take; whatever goes wrong, no file is left.

    Raises:
        Refused: The take is shorter than ``shortest_s``, or the path cannot be written to.
    """
    with TakeRecorder(path, header, shortest_s) as recorder:
        try:
            for markers, pose in frames:
                recorder.add(markers, pose)
            return recorder.seal()
        except BaseException:
            recorder.discard()
            raise


def hand_transforms(geometry: HandGeometry, pose: HandPose) -> Transforms:
    """The palm in the camera frame, every known landmark in the palm frame: frames ``reference/...``."""
    landmarks = forward(geometry, pose.joints_rad).landmarks_m
    known = np.flatnonzero(np.isfinite(landmarks).all(axis=1))
    palm = f"{SPACE}/palm"
    turns = np.tile(_UNTURNED, (known.size + 1, 1))
    turns[0] = pose.q_camera_palm_wxyz
    return Transforms(
        t_ns=pose.t_ns,
        parents=("camera", *(palm for _ in known)),
        children=(palm, *(f"{SPACE}/{LANDMARKS[index]}" for index in known)),
        p_parent_child_m=np.concatenate([pose.p_camera_palm_m[None], landmarks[known]]),
        q_parent_child_wxyz=turns,
    )


@dataclass(frozen=True, slots=True)
class HandMotion:
    """The motion in a take. Gaps are NaN with status LOST.

    Attributes:
        t_ns: Capture times, monotonic, shape (N,).
        t_s: The same in s from the first frame, shape (N,).
        joints_rad: Joint angles, shape (N, 21).
        joint_covariance_rad2: Their covariance, shape (N, 21, 21).
        joint_status: Status of each angle, shape (N, 21).
        fingertips_palm_m: Fingertips in the palm frame, shape (N, 5, 3).
        p_camera_palm_m: Palm origin in the camera frame, shape (N, 3).
        q_camera_palm_wxyz: Rotation from palm to camera, shape (N, 4).
        residual_m: rms distance of fitted from seen markers, shape (N,).
        side: Side of the hand.
        geometry: The hand.
    """

    t_ns: Int64
    t_s: Float64
    joints_rad: Float64
    joint_covariance_rad2: Float64
    joint_status: UInt8
    fingertips_palm_m: Float64
    p_camera_palm_m: Float64
    q_camera_palm_wxyz: Float64
    residual_m: Float64
    side: Side
    geometry: HandGeometry


def read_motion(reader: SessionReader) -> HandMotion:
    """The motion in an open take.

    Raises:
        Refused: The file holds no hand poses for a second or more, or is no take.
    """
    header = reader.header
    if header.kind != "take":
        raise Refused(f"session {reader.path.name}", f"a {header.kind} session", "a take", "choose a take")
    rows = reader.columns(HAND_POSE)
    t_ns: Int64 = rows.t_ns
    duration_s = 1e-9 * float(t_ns[-1] - t_ns[0]) if len(t_ns) else 0.0
    if duration_s < SHORTEST_S:
        raise too_short(duration_s)
    return HandMotion(
        t_ns=t_ns,
        t_s=1e-9 * (t_ns - t_ns[0]).astype(np.float64),
        joints_rad=rows["joints_rad"],
        joint_covariance_rad2=rows["joint_covariance_rad2"],
        joint_status=rows["joint_status"],
        fingertips_palm_m=rows["fingertips_palm_m"],
        p_camera_palm_m=rows["p_camera_palm_m"],
        q_camera_palm_wxyz=rows["q_camera_palm_wxyz"],
        residual_m=rows["residual_m"],
        side=header.side,
        geometry=geometry_from_json(header.subject_hand),
    )


def too_short(duration_s: float, shortest_s: float = SHORTEST_S) -> Refused:
    """The refusal of a take that is too short to use."""
    return Refused(
        "take", f"{duration_s:.2f} s long", f"{shortest_s:g} s or longer", "record it again, for longer"
    )
