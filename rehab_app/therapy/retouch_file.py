"""A retouched take as a file of its own: what was done to which take, by whom and why, stands in it."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np

from rehab_app.recording.take import HandMotion, TakeRecorder, read_motion
from rehab_app.therapy.retouch import Operation, Retouched, retouch
from robot_iface.kinematics import jacobian
from sessions.errors import Refused
from sessions.records import Event, HandPose, MarkerFrame, SessionHeader
from sessions.records.fields import Float64
from sessions.store import SealedSession, SessionReader, verify
from sessions.timebase import Timebase

METADATA = "retouch"
"""Name of the metadata record that holds parent, author, reason, time and operations."""

_TIPS = [3, 7, 11, 15, 19]


def write_retouched(
    parent: Path,
    out: Path,
    operations: tuple[Operation, ...],
    author: str,
    reason: str,
    software_version: str,
) -> SealedSession:
    """Retouch a take into a new one; the old file is only read.

    The new take holds the movement, not the markers and images it was once seen by. Its header names the old
    one's digest as its parent, its events say in sentences what was done, and the metadata record ``retouch``
    holds the operations as JSON.

    Args:
        parent: The take.
        out: The new take; must not exist.
        operations: What to do, in order.
        author: Account of who did it.
        reason: Why, in their words.
        software_version: Of this application.

    Raises:
        Refused: The parent is no intact take, an operation is out of bounds, author or reason is missing, or
            the new take cannot be written. No file is left then.
    """
    for thing, text in (("author of the retouch", author), ("reason for the retouch", reason)):
        if not text.strip():
            raise Refused(thing, "missing", "stated", "state it")
    digest = verify(parent).sha256
    with SessionReader(parent) as reader:
        header, motion = reader.header, read_motion(reader)
    done = retouch(motion, operations)
    facts = {
        "parent": digest,
        "author": author,
        "reason": reason,
        "utc_ns": str(Timebase.now().utc_start_ns),
        "operations": msgspec.json.encode(operations).decode(),
    }
    with TakeRecorder(out, _header(header, digest, software_version)) as recorder:
        try:
            return _written(recorder, done, facts)
        except BaseException:
            recorder.discard()
            raise


def read_operations(text: str) -> tuple[Operation, ...]:
    """The operations in a metadata record.

    Raises:
        Refused: The text holds none.
    """
    try:
        return msgspec.json.decode(text, type=tuple[Operation, ...])
    except msgspec.MsgspecError as error:
        raise Refused("retouch", f"unreadable ({error})", "JSON of operations", "retouch again") from error


def _written(recorder: TakeRecorder, done: Retouched, facts: dict[str, str]) -> SealedSession:
    recorder.attach(METADATA, facts)
    for number, pose in enumerate(_poses(done.motion)):
        recorder.add(_no_markers(pose.t_ns), pose)
        if number == 0:
            origin = f"Retouched from take {facts['parent']} by {facts['author']}: {facts['reason']}"
            recorder.note(_event(pose.t_ns, "retouched", origin))
            for sentence in done.sentences:
                recorder.note(_event(pose.t_ns, f"retouch-{sentence.split()[0].lower()}", sentence))
    return recorder.seal()


def _header(parent: SessionHeader, digest: str, software_version: str) -> SessionHeader:
    return replace(
        parent,
        session_id=uuid.uuid4().hex,
        source=parent.source if parent.source.endswith("retouched") else f"{parent.source}, retouched",
        software_version=software_version,
        marker_names=(),
        consent_images=False,
        parents=(digest,),
    )


def _poses(motion: HandMotion) -> Iterator[HandPose]:
    spread = _tip_covariance(motion)
    for row, t_ns in enumerate(motion.t_ns.tolist()):
        yield HandPose(
            t_ns=t_ns,
            p_camera_palm_m=motion.p_camera_palm_m[row],
            q_camera_palm_wxyz=motion.q_camera_palm_wxyz[row],
            joints_rad=motion.joints_rad[row],
            joint_covariance_rad2=motion.joint_covariance_rad2[row],
            joint_status=motion.joint_status[row],
            fingertips_palm_m=motion.fingertips_palm_m[row],
            fingertip_covariance_m2=spread[row],
            residual_m=float(motion.residual_m[row]),
        )


def _tip_covariance(motion: HandMotion) -> Float64:
    """Covariance of the fingertips, shape (N, 5, 3, 3), NaN where a tip is."""
    known = np.isfinite(motion.joints_rad)
    slopes = jacobian(motion.geometry, np.where(known, motion.joints_rad, 0.0))[:, _TIPS]
    joints = np.nan_to_num(motion.joint_covariance_rad2)
    spread: Float64 = slopes @ joints[:, None] @ np.swapaxes(slopes, -1, -2)
    spread[~np.isfinite(motion.fingertips_palm_m).all(axis=2)] = np.nan
    return spread


def _no_markers(t_ns: int) -> MarkerFrame:
    return MarkerFrame(
        t_ns=t_ns,
        p_camera_m=np.zeros((0, 3)),
        covariance_m2=np.zeros((0, 3, 3)),
        status=np.zeros(0, dtype=np.uint8),
        pixel_px=np.zeros((0, 2)),
        similarity=np.zeros(0),
    )


def _event(t_ns: int, cause: str, text: str) -> Event:
    return Event(
        t_ns=t_ns,
        kind="recording",
        severity="info",
        cause=cause,
        category="",
        subject="",
        value=float("nan"),
        bound=float("nan"),
        text=text,
    )
