"""A clinic with short recorded sessions of the synthetic hand, entered as therapy would."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from rehab_app.access import CONSOLE
from rehab_app.services.clinic import Clinic
from robot_iface.kinematics import average_hand, forward
from sessions.catalogue import TherapySession
from sessions.records import DIGITS, JOINTS, LANDMARKS, SessionHeader
from sessions.records.topics import PATIENT_POSE, PHASE, REFERENCE
from sessions.store import SessionWriter

UTC_NS, SECOND_NS, DAY_NS = 1_790_000_000_000_000_000, 1_000_000_000, 86_400_000_000_000
POSE_HZ, PERIOD_S = 50, 3.0
DRIVEN = tuple(joint for joint in JOINTS if joint.split("_", 1)[1] in ("mcp_flexion", "pip"))


def write_session(path: Path, patient: str, seed: int, seconds: float = 9.0) -> str:
    """A sealed session of closing and opening every three seconds; returns its digest.

    Args:
        path: The file.
        patient: Pseudonym.
        seed: Of the noise, and of how far the hand closes (40 to 60 degrees).
        seconds: Length.
    """
    rng = np.random.default_rng(seed)
    reach_rad = math.radians(float(rng.uniform(40.0, 60.0)))
    t_s = np.arange(round(seconds * POSE_HZ)) / POSE_HZ
    joints = np.zeros((t_s.size, len(JOINTS)))
    for joint in DRIVEN:
        joints[:, JOINTS.index(joint)] = reach_rad * (0.5 - 0.5 * np.cos(2.0 * np.pi * t_s / PERIOD_S))
    tips = forward(average_hand(), joints).landmarks_m[:, [LANDMARKS.index(f"{d}_tip") for d in DIGITS]]
    header = SessionHeader(
        session_id=f"{seed:032x}",
        kind="therapy",
        subject_id=patient,
        side="right",
        exercise="open_close",
        source="exoskeleton",
        software_version="0",
        utc_start_ns=UTC_NS + seed * DAY_NS,
        monotonic_start_ns=SECOND_NS,
        robot_joints=DRIVEN,
        prescription=json.dumps({"repetitions": round(seconds / PERIOD_S)}),
    )
    with SessionWriter(path, header) as writer:
        for row, now_s in enumerate(t_s):
            _write_row(writer, float(now_s), joints[row], tips[row], rng)
        writer.seal()
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _write_row(writer: SessionWriter, now_s: float, joints: Any, tips: Any, rng: np.random.Generator) -> None:
    now_ns, within = SECOND_NS + round(now_s * SECOND_NS), now_s % PERIOD_S
    writer.write(
        REFERENCE,
        REFERENCE.record(t_ns=now_ns, path_s=within, joints_rad=joints, fingertips_palm_m=tips),
    )
    writer.write(
        PATIENT_POSE,
        PATIENT_POSE.record(
            t_ns=now_ns,
            source="encoder",
            joints_rad=joints + rng.normal(0.0, 0.003, len(JOINTS)),
            joint_std_rad=np.full(len(JOINTS), 0.003),
            joint_status=np.full(len(JOINTS), 2, np.uint8),
            fingertips_palm_m=tips + rng.normal(0.0, 0.0003, (len(DIGITS), 3)),
            fingertip_std_m=np.full(len(DIGITS), 0.0003),
        ),
    )
    writer.write(
        PHASE,
        PHASE.record(
            t_ns=now_ns,
            repetition=int(now_s // PERIOD_S),
            phase="rest" if within > PERIOD_S - 0.4 else "move",
            mode="passive",
            started_by="robot",
            path_s=within,
            path_speed=1.0,
            assistance=np.full(len(DIGITS), 3.0),
        ),
    )


def add_sessions(clinic: Clinic, count: int, seconds: float = 9.0, start: int = 1) -> tuple[str, ...]:
    """Enter sessions of one new patient, a day apart; returns their catalogue ids."""
    patient = clinic.patients.add(
        CONSOLE, given_name="Eva", family_name=f"Lind{start}", birth_date="1960-02-29", side="right"
    )
    (clinic.folder / "sessions").mkdir(exist_ok=True)
    ids: list[str] = []
    for seed in range(start, start + count):
        name = f"sessions/{seed}.mcap"
        digest = write_session(clinic.folder / name, patient.id, seed, seconds)
        entered = clinic.catalogue.add_session(
            TherapySession(
                patient=patient.id,
                sha256=digest,
                path=name,
                mode="passive",
                started_utc_ns=UTC_NS + seed * DAY_NS,
            )
        )
        ids.append(entered.id)
    return tuple(ids)
