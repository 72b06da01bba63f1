"""Measures a therapy session: the patient's hand beside the therapist's, and who did the work."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sessions.errors import Refused
from sessions.metrics.device_end import at_device_end, ends_of
from sessions.metrics.dose import dose_completed, time_in
from sessions.metrics.followed import Followed, decomposed_metrics, followed_by, pair, tracking_metrics
from sessions.metrics.hand_motion import (
    HandMotion,
    active_motion_metrics,
    at_rows,
    main_cycles,
    range_metrics,
    stroke_metrics,
)
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.opening_numbers import opening_metrics
from sessions.metrics.overlay import thin
from sessions.metrics.recording import ACTIVE_PHASES, Origin, Phases, Recording, read_phases, seconds
from sessions.metrics.robot_blocks import RobotTicks, effort_metrics
from sessions.metrics.robot_fold import fold
from sessions.metrics.separated import PassiveRun, separated_metrics, separation
from sessions.metrics.started import start_metrics
from sessions.metrics.summary import Overlay, Repetition, Stop, Summary
from sessions.metrics.support import conditions, mean_assistance, modes, support_metrics
from sessions.records.topics import EVENTS, PATIENT_POSE, PHASE, REFERENCE


@dataclass(frozen=True, slots=True)
class _Read:
    """The columns of a session, read once."""

    phases: Phases
    patient: HandMotion
    followed: Followed
    robot: RobotTicks
    origin: Origin
    conditions: str


def measure_therapy(recording: Recording, passive: PassiveRun | None = None) -> Summary:
    """All numbers of a therapy session.

    Args:
        recording: The opened file.
        passive: A passive run of the same hand, day and device, to be taken off; by default the session's own
            passive repetitions.

    Raises:
        Refused: The file holds no patient pose or no reference.
    """
    read, support = _read(recording, passive)
    stops = _stops(recording, int(read.patient.t_ns[0]))
    repetitions = _repetitions(read)
    moving = read.phases.active_repetition(read.patient.t_ns) >= 0
    strokes = main_cycles(read.patient, moving).strokes_s
    moved = "passive" in modes(read.phases) or "assistive" in modes(read.phases)
    ends = ends_of(recording.header.limits, recording.header.robot_joints)
    numbers = [
        *tracking_metrics(read.followed, read.origin, read.conditions),
        *decomposed_metrics(read.followed, read.origin, read.conditions),
        *support,
        *start_metrics(read.phases, read.followed, read.origin),
        *effort_metrics(read.robot, read.origin),
        *separated_metrics(read.robot.separation, read.robot.t_ns, read.origin),
        *_dose(read, repetitions, stops, recording.header.prescription),
        *at_device_end(range_metrics(read.patient, read.origin), ends),
        *stroke_metrics(read.patient, strokes, read.origin),
        *active_motion_metrics(read.patient, read.origin, "the robot moved the hand" if moved else ""),
        *opening_metrics(read.patient, recording.header.subject_hand, read.origin),
    ]
    t_ns = read.patient.t_ns
    return Summary(
        recording.header,
        recording.sha256,
        float(t_ns[-1] - t_ns[0]) * 1e-9,
        modes(read.phases),
        read.conditions,
        tuple(numbers),
        tuple(repetitions),
        stops,
        _overlay(read.followed, repetitions),
        "" if passive is None else passive.sha256,
    )


def _read(recording: Recording, passive: PassiveRun | None) -> tuple[_Read, list[Metric]]:
    for topic in (PATIENT_POSE, REFERENCE, PHASE):
        if recording.counts.get(topic.name, 0) < 2:
            raise Refused(
                f"session {recording.header.session_id[:8]}",
                f"without {topic.name}",
                "a therapy session with patient, reference and phases",
                "report it as a take, or play the take again",
            )
    phases = read_phases(recording)
    if not np.isin(phases.phase, ACTIVE_PHASES).any():
        raise Refused(
            f"session {recording.header.session_id[:8]}",
            "without a repetition",
            "a session in which a movement was repeated",
            "look at it with rehab-app info, or report another session",
        )
    patient, source = _patient(recording)
    origin = Origin(recording.sha256, source)
    folded = fold(recording)
    words = conditions(phases, folded.stiffness)
    followed = _followed(recording, patient, phases)
    known = separation(recording, folded.stretches, passive)
    robot = RobotTicks(recording.header.robot_joints if folded.stretches else (), folded.stretches, known)
    return _Read(phases, patient, followed, robot, origin, words), support_metrics(phases, folded, origin)


def _patient(recording: Recording) -> tuple[HandMotion, str]:
    rows = recording.columns(PATIENT_POSE)
    motion = HandMotion(
        PATIENT_POSE,
        np.asarray(rows["t_ns"], dtype=np.int64),
        np.asarray(rows["joints_rad"], dtype=np.float64),
        np.asarray(rows["joint_std_rad"], dtype=np.float64),
        np.asarray(rows["joint_status"], dtype=np.uint8),
        np.asarray(rows["fingertips_palm_m"], dtype=np.float64),
        np.asarray(rows["fingertip_std_m"], dtype=np.float64),
    )
    return motion, " and ".join(sorted(set[str](rows["source"].tolist())))


def _followed(recording: Recording, patient: HandMotion, phases: Phases) -> Followed:
    rows = recording.columns(REFERENCE)
    joints = np.asarray(rows["joints_rad"], dtype=np.float64)
    tips = np.asarray(rows["fingertips_palm_m"], dtype=np.float64)
    of_patient, of_reference = pair(patient, np.asarray(rows["t_ns"], dtype=np.int64), joints, tips)
    paired = patient.at(of_patient)
    repetition = phases.active_repetition(paired.t_ns)
    joints, tips = at_rows(joints, of_reference), at_rows(tips, of_reference)
    return followed_by(paired, joints, tips, repetition)


def _repetitions(read: _Read) -> list[Repetition]:
    phases, found = read.phases, list[Repetition]()
    active = np.isin(phases.phase, ACTIVE_PHASES) & (phases.repetition >= 0)
    every = list(range(len(read.robot.joints)))
    start_ns = int(read.patient.t_ns[0])
    for index in np.unique(phases.repetition[active]):
        rows = np.flatnonzero(active & (phases.repetition == index))
        after = int(rows[-1]) + 1
        ended = after < phases.t_ns.size
        chosen = read.followed.moving(int(index))
        found.append(
            Repetition(
                int(index),
                float(phases.t_ns[rows[0]] - start_ns) * 1e-9,
                float(phases.t_ns[after if ended else rows[-1]] - start_ns) * 1e-9,
                str(phases.started_by[rows[-1]]),
                ended and str(phases.phase[after]) != "stopped",
                read.followed.joint_rmse(chosen).value if read.conditions else float("nan"),
                read.followed.fingertip_rmse(chosen).value if read.conditions else float("nan"),
                tuple(float(value) for value in mean_assistance(phases.assistance[rows])),
                read.robot.share(every, int(index)).value,
            )
        )
    return found


def _dose(read: _Read, repetitions: list[Repetition], stops: tuple[Stop, ...], ordered: str) -> list[Metric]:
    completed = [item for item in repetitions if item.completed]
    by_patient = sum(item.started_by == "patient" for item in completed)
    lineage = read.origin.lineage((PHASE,), read.phases.t_ns)
    of_events = read.origin.lineage((EVENTS,), read.phases.t_ns)
    t_s, seen_s = ((t_ns - read.phases.t_ns[0]) * 1e-9 for t_ns in (read.phases.t_ns, read.patient.t_ns))
    rows = (
        ("repetitions", Estimate(float(len(completed)))),
        ("repetitions_by_patient", Estimate(float(by_patient))),
        ("dose_time", time_in(t_s, read.phases.phase, ACTIVE_PHASES, seen_s)),
        ("dose_completed", dose_completed(len(completed), ordered)),
    )
    found = [metric(name, "whole", value, lineage) for name, value in rows]
    return [*found, metric("stops", "whole", Estimate(float(len(stops))), of_events)]


def _stops(recording: Recording, start_ns: int) -> tuple[Stop, ...]:
    if not recording.counts.get(EVENTS.name, 0):
        return ()
    rows = recording.columns(EVENTS)
    return tuple(
        Stop(float(t_ns - start_ns) * 1e-9, str(cause), str(category), str(text))
        for t_ns, kind, cause, category, text in zip(
            rows["t_ns"], rows["kind"], rows["cause"], rows["category"], rows["text"], strict=True
        )
        if str(kind) == "stop"
    )


def _overlay(followed: Followed, repetitions: list[Repetition]) -> Overlay:
    """The last completed repetition, or the last one, or everything where there was none."""
    completed = [item for item in repetitions if item.completed] or repetitions
    if completed:
        last = completed[-1].index
        rows, shown = followed.moving(last), f"repetition {last + 1} of {len(repetitions)}"
    else:
        rows, shown = np.arange(followed.repetition.size), "the whole session"
    patient = followed.patient
    t_s = seconds(patient.t_ns[rows])
    return Overlay(
        shown,
        thin(t_s, patient.joints_rad[rows], followed.tips_m[rows]),
        thin(t_s, followed.reference_joints_rad[rows], followed.reference_tips_m[rows]),
    )
