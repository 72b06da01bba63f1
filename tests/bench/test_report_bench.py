"""Report of a 30-minute session with 1 kHz telemetry, progress of 200 sessions: times and memory, printed."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from robot_iface.kinematics import average_hand, forward
from sessions.catalogue import TherapySession
from sessions.records import DIGITS, JOINTS, LANDMARKS, SessionHeader, columns_of
from sessions.records.topics import PATIENT_POSE, PHASE, REFERENCE, ROBOT_COMMAND, ROBOT_STATE
from sessions.reports.past import Kept, Past, Trial, past_to_json, past_version
from sessions.store import SessionWriter

pytestmark = pytest.mark.bench

MINUTES, POSE_HZ, TICK_HZ, BLOCK = 30, 100, 1000, 50
PERIOD_S = 6.0
UTC_NS, START_NS, SECOND_NS = 1_790_000_000_000_000_000, 5_000_000_000, 1_000_000_000
DRIVEN = tuple(joint for joint in JOINTS if joint.split("_", 1)[1] in ("mcp_flexion", "pip"))
SESSIONS = 200
NUMBERS = (
    (("range_of_motion", "angle_min", "angle_max", "joint_rmse", "interaction_torque"), JOINTS),
    (("fingertip_rmse", "sparc", "ldlj", "movement_time", "peak_speed", "path_ratio"), DIGITS),
    (("repetitions", "repetitions_by_patient", "dose_time", "joint_rmse"), ("whole",)),
    (("stiffness",), DRIVEN),
)
"""About as many as a real session has."""
MEASURE = """
import resource, sys, time
from pathlib import Path
start = time.perf_counter()
from sessions.reports import FORMATS, build_report
report = build_report([Path(sys.argv[1])])
measured = time.perf_counter()
size = len(FORMATS[sys.argv[2]].render(report))
rendered = time.perf_counter()
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
FORMATS[sys.argv[2]].render(build_report([Path(sys.argv[1])]))
again = time.perf_counter() - rendered
print(measured - start, rendered - measured, again, peak / 1024, size)
"""


def shape(t_s: Any) -> Any:
    """0 open, 1 closed, smooth, every ``PERIOD_S``."""
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * t_s / PERIOD_S)


def joints_at(t_s: Any) -> Any:
    joints = np.zeros((len(t_s), len(JOINTS)))
    for joint in DRIVEN:
        joints[:, JOINTS.index(joint)] = math.radians(50.0) * shape(t_s)
    return joints


@pytest.fixture(scope="module")
def long_session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Thirty minutes of repetitions: poses at 100 Hz, robot state and command at 1 kHz in blocks."""
    path = tmp_path_factory.mktemp("long") / "session.mcap"
    header = SessionHeader(
        session_id="0" * 32,
        kind="therapy",
        subject_id="P-0001",
        side="right",
        exercise="open_close",
        source="exoskeleton",
        software_version="0",
        utc_start_ns=UTC_NS,
        monotonic_start_ns=START_NS,
        robot_joints=DRIVEN,
        prescription=json.dumps({"repetitions": round(60 * MINUTES / PERIOD_S)}),
    )
    one_s = np.arange(round(PERIOD_S * POSE_HZ)) / POSE_HZ
    joints = joints_at(one_s)
    tips = forward(average_hand(), joints).landmarks_m[:, [LANDMARKS.index(f"{d}_tip") for d in DIGITS]]
    rng = np.random.default_rng(3)
    status = np.full(21, 2, np.uint8)
    with SessionWriter(path, header) as writer:
        for row in range(60 * MINUTES * POSE_HZ):
            now_ns, at = START_NS + row * SECOND_NS // POSE_HZ, row % len(one_s)
            writer.write(
                REFERENCE,
                REFERENCE.record(
                    t_ns=now_ns, path_s=float(one_s[at]), joints_rad=joints[at], fingertips_palm_m=tips[at]
                ),
            )
            writer.write(
                PATIENT_POSE,
                PATIENT_POSE.record(
                    t_ns=now_ns,
                    source="encoder",
                    joints_rad=joints[at] + rng.normal(0.0, 0.003, 21) - 0.02,
                    joint_std_rad=np.full(21, 0.003),
                    joint_status=status,
                    fingertips_palm_m=tips[at] + rng.normal(0.0, 0.0003, (5, 3)),
                    fingertip_std_m=np.full(5, 0.0003),
                ),
            )
            if row % (POSE_HZ // 10) == 0:
                writer.write(PHASE, _phase(now_ns, row / POSE_HZ))
            if row % (BLOCK * POSE_HZ // TICK_HZ) == 0:
                _block(writer, now_ns, row / POSE_HZ, rng)
        writer.seal()
    return path


def _phase(now_ns: int, now_s: float) -> Any:
    within = now_s % PERIOD_S
    return PHASE.record(
        t_ns=now_ns,
        repetition=int(now_s // PERIOD_S),
        phase="rest" if within > PERIOD_S - 0.5 else "move",
        mode="passive",
        started_by="robot",
        path_s=within,
        path_speed=1.0,
        assistance=np.full(5, 3.0),
    )


def _block(writer: SessionWriter, now_ns: int, now_s: float, rng: np.random.Generator) -> None:
    t_s = now_s + np.arange(BLOCK) / TICK_HZ
    t_ns = now_ns + np.arange(BLOCK) * (SECOND_NS // TICK_HZ)
    q = np.repeat(math.radians(50.0) * shape(t_s)[:, None], len(DRIVEN), axis=1)
    for topic in (ROBOT_STATE, ROBOT_COMMAND):
        values: dict[str, Any] = {}
        for name, column in columns_of(topic.record).items():
            size = (BLOCK,) if len(column.shape) == 1 else (BLOCK, len(DRIVEN))
            values[name] = np.zeros(size, np.dtype(column.scalar))
        values |= {"t_ns": t_ns, "q_rad": q + rng.normal(0.0, 1e-4, q.shape)}
        if topic is ROBOT_STATE:
            values["dq_rad_s"] = np.gradient(q, 1.0 / TICK_HZ, axis=0)
            values["tau_interaction_nm"] = 0.05 * q + rng.normal(0.0, 1e-3, q.shape)
        else:
            values["stiffness_nm_rad"] = np.full(q.shape, 0.9)
        writer.write(topic, topic.record(**values))


@pytest.mark.parametrize("format_name", ["html", "pdf", "json"])
def test_report_of_half_an_hour(long_session: Path, format_name: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", MEASURE, str(long_session), format_name],
        capture_output=True,
        text=True,
        check=True,
    )
    measured_s, rendered_s, again_s, peak_mib, size = (float(word) for word in done.stdout.split())
    megabytes = long_session.stat().st_size / 1e6
    sys.stdout.write(
        f"\nreport of {MINUTES} min, 1 kHz, {len(DRIVEN)} joints, {megabytes:.0f} MB, as {format_name}: "
        f"measure {measured_s:.2f} s, render {rendered_s:.2f} s, "
        f"with all imports {measured_s + rendered_s:.2f} s, again in that process {again_s:.2f} s (aim 5), "
        f"peak {peak_mib:.0f} MiB (aim 600), {size / 1e3:.0f} kB\n"
    )
    assert rendered_s < 5.0 * measured_s


def test_progress_of_two_hundred_sessions(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    with open_clinic(tmp_path) as clinic:
        patient = clinic.patients.add(
            CONSOLE, given_name="A", family_name="B", birth_date="1960-01-01", side="right"
        ).id
        for number in range(SESSIONS):
            _keep(clinic, patient, number, rng)
        start, cpu = time.perf_counter(), time.process_time()
        found = clinic.progress.of_patient(patient)
        read = time.perf_counter()
        page = clinic.progress.rendered(found, "html")
        done, cpu = time.perf_counter(), time.process_time() - cpu
        clinic.progress.rendered(clinic.progress.of_patient(patient), "html")
        again_s = time.perf_counter() - done
    sys.stdout.write(
        f"\nprogress of {SESSIONS} sessions from the catalogue: read {read - start:.2f} s, "
        f"render {done - read:.2f} s, together {done - start:.2f} s, again {again_s:.2f} s (aim 2), "
        f"processor {cpu:.2f} s, {len(page) / 1e3:.0f} kB\n"
    )
    assert len(found.pasts) == SESSIONS


def _keep(clinic: Any, patient: str, number: int, rng: np.random.Generator) -> None:
    """One session with as many numbers as a real one."""
    names = [(name, subject) for group, subjects in NUMBERS for name in group for subject in subjects]
    numbers = tuple(
        Kept(
            name,
            subject,
            value := float(rng.uniform(0.5, 1.0)),
            value - 0.01,
            value + 0.01,
            "ok",
            "1",
            "encoder",
        )
        for name, subject in names
    )
    utc_ns = UTC_NS + number * 86_400 * SECOND_NS
    made = Past(
        session_id="x",
        sha256=f"{number:064x}",
        subject_id=patient,
        utc_start_ns=utc_ns,
        side="right",
        exercise="open_close",
        modes=("passive",),
        conditions="stiffness 0.90 Nm/rad",
        duration_s=1800.0,
        numbers=numbers,
        trials=tuple(Trial(index, True, "robot", ()) for index in range(100)),
    )
    clinic.catalogue.add_session(
        TherapySession(
            patient=patient,
            sha256=made.sha256,
            path=f"sessions/{number}.mcap",
            mode="passive",
            started_utc_ns=utc_ns,
        )
    )
    clinic.catalogue.keep_metrics(made.sha256, past_version(), past_to_json(made))
