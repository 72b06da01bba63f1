"""Opens a sealed session or take for the review viewport."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from rehab_app.hand.retarget import ROBOT_JOINTS
from rehab_app.hand.subject import geometry_from_json
from rehab_app.services.replay_repetitions import of_movement, of_session
from rehab_app.services.rows import Replay
from sessions.errors import Refused
from sessions.records import Event
from sessions.records.fields import Float64, Int64
from sessions.records.topics import HAND_POSE, PATIENT_POSE, PHASE, REFERENCE
from sessions.store import SessionReader

RATE_HZ = 50.0
COMPARED_PHASES = ("move", "hold")
"""Phases in which the patient is compared with the therapist, here as in the report."""


def replay_of(path: Path) -> Replay:
    """Read what the viewport draws.

    Args:
        path: Sealed session or take.

    Raises:
        Refused: The file is no sealed session, or holds no hand.
    """
    with SessionReader(path) as reader:
        found = _session(reader) if reader.header.kind == "therapy" else _take(reader)
        worn = reader.header.robot_joints != ROBOT_JOINTS
        return replace(found, prescription=reader.header.prescription, worn=worn)


def _take(reader: SessionReader) -> Replay:
    rows = reader.columns(HAND_POSE, names=("joints_rad",))
    t_ns = np.asarray(rows["t_ns"], dtype=np.int64)
    chosen = _thinned(t_ns, reader.path)
    t_s = _since(t_ns[chosen], int(t_ns[0]))
    joints = np.asarray(rows["joints_rad"], dtype=np.float64)[chosen]
    return Replay(
        t_s=t_s,
        reference_joints_rad=None,
        patient_joints_rad=joints,
        fingertip_error_m=None,
        phases=(),
        events=_events(reader, int(t_ns[0])),
        geometry=geometry_from_json(reader.header.subject_hand),
        side=reader.header.side,
        repetitions_s=of_movement(t_s, joints),
    )


def _session(reader: SessionReader) -> Replay:
    patient = reader.columns(PATIENT_POSE, names=("joints_rad", "fingertips_palm_m"))
    reference = reader.columns(REFERENCE, names=("joints_rad", "fingertips_palm_m"))
    if not np.asarray(reference["t_ns"]).size:
        return _sweep(reader, np.asarray(patient["t_ns"], dtype=np.int64), patient["joints_rad"])
    t_ns, of_patient, of_reference = np.intersect1d(
        np.asarray(patient["t_ns"], dtype=np.int64),
        np.asarray(reference["t_ns"], dtype=np.int64),
        return_indices=True,
    )
    chosen = _thinned(t_ns, reader.path)
    of_patient, of_reference = of_patient[chosen], of_reference[chosen]
    apart = patient["fingertips_palm_m"][of_patient] - reference["fingertips_palm_m"][of_reference]
    phases = _phases(reader, t_ns[chosen])
    error_m = np.sqrt(np.mean(np.sum(apart**2, axis=2), axis=1))
    error_m[~np.isin(phases, COMPARED_PHASES)] = np.nan
    geometry = geometry_from_json(reader.header.subject_hand)
    return Replay(
        t_s=_since(t_ns[chosen], int(t_ns[0])),
        reference_joints_rad=np.asarray(reference["joints_rad"], dtype=np.float64)[of_reference],
        patient_joints_rad=np.asarray(patient["joints_rad"], dtype=np.float64)[of_patient],
        fingertip_error_m=error_m,
        phases=phases,
        events=_events(reader, int(t_ns[0])),
        geometry=geometry,
        side=reader.header.side,
        reference_geometry=geometry,
        repetitions_s=of_session(reader, int(t_ns[0]), int(t_ns[-1])),
    )


def _sweep(reader: SessionReader, t_ns: Int64, joints_rad: Float64) -> Replay:
    """A guided assessment: nobody is followed, so there is nothing to compare with."""
    chosen = _thinned(t_ns, reader.path)
    return Replay(
        t_s=_since(t_ns[chosen], int(t_ns[0])),
        reference_joints_rad=None,
        patient_joints_rad=np.asarray(joints_rad, dtype=np.float64)[chosen],
        fingertip_error_m=None,
        phases=_phases(reader, t_ns[chosen]),
        events=_events(reader, int(t_ns[0])),
        geometry=geometry_from_json(reader.header.subject_hand),
        side=reader.header.side,
        repetitions_s=of_session(reader, int(t_ns[0]), int(t_ns[-1])),
    )


def _thinned(t_ns: Int64, path: Path) -> Int64:
    """Rows at no more than 50 Hz, the first and last among them."""
    if t_ns.size == 0:
        raise Refused(f"file {path.name!r}", "without a hand", "a recorded hand", "choose another recording")
    slot = ((t_ns - t_ns[0]) * RATE_HZ / 1e9 + 0.5).astype(np.int64)
    first = np.flatnonzero(np.diff(slot, prepend=-1) > 0)
    return first if first[-1] == t_ns.size - 1 else np.append(first, t_ns.size - 1)


def _phases(reader: SessionReader, t_ns: Int64) -> tuple[str, ...]:
    """The phase that holds at each time; the first one before it was written."""
    rows = reader.columns(PHASE, names=("phase",))
    times = np.asarray(rows["t_ns"], dtype=np.int64)
    if times.size == 0:
        return ("",) * t_ns.size
    held = np.clip(np.searchsorted(times, t_ns, side="right") - 1, 0, None)
    return tuple(str(phase) for phase in np.asarray(rows["phase"])[held])


def _events(reader: SessionReader, start_ns: int) -> tuple[Event, ...]:
    return tuple(replace(event, t_ns=event.t_ns - start_ns) for event in reader.events())


def _since(t_ns: Int64, start_ns: int) -> Float64:
    return (t_ns - start_ns) / 1e9
