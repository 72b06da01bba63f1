"""The patient's own work in a session: recoil taken off where a passive run of the same day tells it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.effort import FLOOR_NM, MOVED_RAD, NOT_SEPARABLE, work_share
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.passive_curve import OwnWork, PassiveCurve, own_work, passive_curve
from sessions.metrics.recording import Origin, Phases, Recording, read_phases, seconds
from sessions.records import SessionHeader
from sessions.records.fields import Float64, Int64
from sessions.records.topics import PHASE, ROBOT_STATE

_DAY_NS = 86_400_000_000_000
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

    def unlike(self, header: SessionHeader) -> str:
        """Why it cannot be taken off that session, empty where it can."""
        mine = self.header
        if (mine.subject_id, mine.side) != (header.subject_id, header.side):
            return "not separable: the passive run is of another hand"
        if mine.utc_start_ns // _DAY_NS != header.utc_start_ns // _DAY_NS:
            return "not separable: the passive run is of another day"
        if (mine.robot_joints, mine.source) != (header.robot_joints, header.source):
            return "not separable: the passive run is of another device"
        return ""


@dataclass(frozen=True, slots=True)
class _Ticks:
    """What the robot measured within repetitions, N ticks and J joints."""

    t_s: Float64
    q_rad: Float64
    dq_rad_s: Float64
    tau_nm: Float64
    passive: NDArray[np.bool_]
    t_ns: Int64


def read_passive(recording: Recording) -> PassiveRun:
    """The passive curves of a session; none where no repetition of it was passive."""
    ticks = _ticks(recording, read_phases(recording))
    return PassiveRun(recording.header, recording.sha256, _curves(recording.header, ticks))


def separated_metrics(
    recording: Recording, phases: Phases, origin: Origin, passive: PassiveRun | None = None
) -> list[Metric]:
    """Work share and the patient's work, of the repetitions that were not passive.

    Args:
        recording: The session.
        phases: Its phases.
        origin: Which file.
        passive: A passive run of the same hand, day and device; by default the session's own passive
            repetitions.
    """
    ticks = _ticks(recording, phases)
    header = recording.header
    run = passive or PassiveRun(header, recording.sha256, _curves(header, ticks))
    reason = run.unlike(header)
    if ticks is None or bool(ticks.passive.all()):
        reason = reason or "no repetition in which the patient was to move"
    elif not run.curves:
        reason = reason or NOT_SEPARABLE
    if ticks is None or reason:
        lineage = origin.lineage((ROBOT_STATE, PHASE), phases.t_ns)
        return [metric(name, "whole", Estimate.missing(reason), lineage) for name in _NAMES]
    conditions = f"passive curve of file {run.sha256[:12]}"
    lineage = origin.lineage((ROBOT_STATE, PHASE), ticks.t_ns, conditions)
    parts = _together(_by_joint(header, ticks, run.curves))
    return [metric(name, "whole", value, lineage) for name, value in zip(_NAMES, parts, strict=True)]


def _by_joint(header: SessionHeader, ticks: _Ticks, curves: Mapping[str, PassiveCurve]) -> list[OwnWork]:
    """Own work of every joint that moved; of one without a curve it is missing."""
    own = ~ticks.passive
    found: list[OwnWork] = []
    for column, joint in enumerate(header.robot_joints):
        q = ticks.q_rad[own, column]
        if float(np.ptp(q)) < MOVED_RAD:
            continue
        if joint not in curves:
            missing = Estimate.missing(f"not separable: no passive curve of {joint}")
            found.append(OwnWork(missing, missing, missing, missing))
            continue
        curve = curves[joint]
        found.append(
            own_work(ticks.t_s[own], q, ticks.dq_rad_s[own, column], ticks.tau_nm[own, column], curve)
        )
    return found


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


def _curves(header: SessionHeader, ticks: _Ticks | None) -> dict[str, PassiveCurve]:
    if ticks is None or not bool(ticks.passive.any()):
        return {}
    rows = ticks.passive
    found: dict[str, PassiveCurve] = {}
    for column, joint in enumerate(header.robot_joints):
        tau = ticks.tau_nm[rows, column]
        curve = passive_curve(ticks.q_rad[rows, column], ticks.dq_rad_s[rows, column], tau)
        if curve is not None:
            found[joint] = curve
    return found


def _ticks(recording: Recording, phases: Phases) -> _Ticks | None:
    """Ticks within repetitions, None where the file has none or the device measures no torque."""
    joints = recording.header.robot_joints
    if not joints or not recording.counts.get(ROBOT_STATE.name, 0) or not phases.t_ns.size:
        return None
    rows = recording.columns(ROBOT_STATE)
    t_ns: Int64 = np.asarray(rows["t_ns"], dtype=np.int64)
    chosen = np.flatnonzero(phases.active_repetition(t_ns) >= 0)
    if not chosen.size:
        return None
    q, dq, tau = (
        np.asarray(rows[name], dtype=np.float64).reshape(t_ns.size, len(joints))[chosen]
        for name in ("q_rad", "dq_rad_s", "tau_interaction_nm")
    )
    if not bool(np.isfinite(tau).any()) or float(np.sqrt(np.nanmean(tau**2))) < 0.1 * FLOOR_NM:
        return None
    passive = phases.mode[phases.rows_at(t_ns[chosen])] == "passive"
    return _Ticks(seconds(t_ns[chosen]), q, dq, tau, np.asarray(passive, dtype=np.bool_), t_ns[chosen])
