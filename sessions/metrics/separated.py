"""The patient's own work in a session: recoil taken off where a passive run of the same day tells it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.effort import FLOOR_NM, MOVED_RAD, NOT_SEPARABLE, work_share
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.passive_curve import OwnWork, PassiveCurve, own_work, passive_curve
from sessions.metrics.recording import Origin, Recording, seconds
from sessions.metrics.robot_fold import fold
from sessions.metrics.robot_stretch import Stretch, Track, joined_track
from sessions.records import SessionHeader
from sessions.records.fields import Int64
from sessions.records.topics import PHASE, ROBOT_STATE

_DAY_NS = 86_400_000_000_000
UNTOLD = "the robot measured no torque within a repetition"
PASSIVE = "not separable: in passive mode what comes back is recoil or friction"
_NAMES = ("work_share", "patient_work", "resisting_work")


@dataclass(frozen=True, slots=True)
class PassiveRun:
    """What a passive run tells of one hand on one day.

    Attributes:
        header: Header of the file.
        sha256: Its digest.
        curves: Curves by robot joint.
    """

    header: SessionHeader
    sha256: str
    curves: Mapping[str, PassiveCurve]


def unlike(run: SessionHeader, header: SessionHeader) -> str:
    """Why a passive run cannot be taken off a session, empty where it can; from their headers."""
    if (run.subject_id, run.side) != (header.subject_id, header.side):
        return "not separable: the passive run is of another hand"
    if run.utc_start_ns // _DAY_NS != header.utc_start_ns // _DAY_NS:
        return "not separable: the passive run is of another day"
    if (run.robot_joints, run.source) != (header.robot_joints, header.source):
        return "not separable: the passive run is of another device"
    return ""


@dataclass(frozen=True, slots=True)
class Separation:
    """What is known of the patient's own part in the work of a session.

    Attributes:
        joints: Names of the J robot joints.
        track: What the robot measured within repetitions; None where it measured no torque.
        curves: Passive curves by robot joint.
        reason: Why nothing can be separated, empty where it can.
        conditions: Which file the curves are from, in words.
    """

    joints: tuple[str, ...]
    track: Track | None
    curves: Mapping[str, PassiveCurve]
    reason: str
    conditions: str = ""

    def share(self, columns: Sequence[int], repetition: int | None = None) -> Estimate:
        """Robot's share over some joints, in one repetition or in all, recoil taken off."""
        return self.parts(columns, repetition)[0]

    def parts(
        self, columns: Sequence[int], repetition: int | None = None
    ) -> tuple[Estimate, Estimate, Estimate]:
        """Robot's share, the patient's work along the movement, and against it."""
        if self.track is None or self.reason:
            missing = Estimate.missing(self.reason or UNTOLD)
            return missing, missing, missing
        rows = ~self.track.passive
        rows &= self.track.repetition == repetition if repetition is not None else True
        if not bool(rows.any()):
            missing = Estimate.missing(PASSIVE)
            return missing, missing, missing
        return _together([work for column in columns if (work := self._own(column, rows)) is not None])

    def _own(self, column: int, rows: NDArray[np.bool_]) -> OwnWork | None:
        """Own work at one joint, None where it hardly moved; missing without a curve."""
        track, joint = self.track, self.joints[column]
        q = track.q_rad[rows, column] if track is not None else np.empty(0)
        if track is None or float(np.ptp(q)) < MOVED_RAD:
            return None
        if joint not in self.curves:
            missing = Estimate.missing(f"not separable: no passive curve of {joint}")
            return OwnWork(missing, missing, missing, missing)
        t_s = seconds(track.t_ns[rows])
        return own_work(t_s, q, track.dq_rad_s[rows, column], track.tau_nm[rows, column], self.curves[joint])


def read_passive(recording: Recording) -> PassiveRun:
    """The passive curves of a session; none where no repetition of it was passive."""
    track = _measured(joined_track(fold(recording).stretches))
    return PassiveRun(recording.header, recording.sha256, _curves(recording.header, track))


def separation(
    recording: Recording, stretches: Sequence[Stretch], passive: PassiveRun | None = None
) -> Separation:
    """What can be told of the patient's own part.

    Args:
        recording: The session.
        stretches: What the robot measured within its repetitions.
        passive: A passive run of the same hand, day and device; by default the session's own passive
            repetitions.
    """
    header, track = recording.header, _measured(joined_track(stretches))
    if track is None or bool(track.passive.all()):
        return Separation(header.robot_joints, track, {}, UNTOLD if track is None else PASSIVE)
    run = passive or PassiveRun(header, recording.sha256, _curves(header, track))
    reason = unlike(run.header, header) or ("" if run.curves else NOT_SEPARABLE)
    conditions = "" if reason else f"passive curve of file {run.sha256}"
    return Separation(header.robot_joints, track, run.curves, reason, conditions)


def separated_metrics(known: Separation, t_ns: Int64, origin: Origin) -> list[Metric]:
    """Work share and the patient's work, of the repetitions that were not passive.

    Args:
        known: What can be told.
        t_ns: Times of the first and last tick within repetitions.
        origin: Which file.
    """
    lineage = origin.lineage((ROBOT_STATE, PHASE), t_ns, known.conditions)
    parts = known.parts(range(len(known.joints)))
    return [metric(name, "whole", value, lineage) for name, value in zip(_NAMES, parts, strict=True)]


def _together(joints: list[OwnWork]) -> tuple[Estimate, Estimate, Estimate]:
    """Over all joints; where one cannot be separated, the whole cannot."""
    if not joints:
        missing = Estimate.missing("no joint moved by 3 degrees")
        return missing, missing, missing
    lost = next((joint.patient_j for joint in joints if not math.isfinite(joint.patient_j.value)), None)
    if lost is not None:
        return lost, lost, lost
    patient, resisting, robot = (
        _sum([getattr(joint, name) for joint in joints]) for name in ("patient_j", "resisting_j", "robot_j")
    )
    shares = [
        work_share(np.array([of_robot]), np.array([of_patient]), np.ones(1))
        for of_robot, of_patient in (
            (robot.value, patient.value),
            (_low(robot), _high(patient)),
            (_high(robot), _low(patient)),
        )
    ]
    low, high = shares[1].value, shares[2].value
    interval = (low, high) if math.isfinite(low) and math.isfinite(high) else None
    return Estimate(shares[0].value, interval, shares[0].reason), patient, resisting


def _sum(parts: list[Estimate]) -> Estimate:
    return Estimate(sum(part.value for part in parts), (sum(map(_low, parts)), sum(map(_high, parts))))


def _low(part: Estimate) -> float:
    return part.value if part.interval is None else part.interval[0]


def _high(part: Estimate) -> float:
    return part.value if part.interval is None else part.interval[1]


def _curves(header: SessionHeader, track: Track | None) -> dict[str, PassiveCurve]:
    if track is None or not bool(track.passive.any()):
        return {}
    rows = track.passive
    found: dict[str, PassiveCurve] = {}
    for column, joint in enumerate(header.robot_joints):
        tau = track.tau_nm[rows, column]
        curve = passive_curve(track.q_rad[rows, column], track.dq_rad_s[rows, column], tau)
        if curve is not None:
            found[joint] = curve
    return found


def _measured(track: Track | None) -> Track | None:
    """None where the device measures no torque."""
    if track is None or not bool(np.isfinite(track.tau_nm).any()):
        return None
    return track if float(np.sqrt(np.nanmean(track.tau_nm**2))) >= 0.1 * FLOOR_NM else None
