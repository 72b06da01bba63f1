"""Recordings in memory whose truth is known: a take and a therapy session, as a reader would show them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from robot_iface.kinematics import average_hand, forward
from sessions.records import DIGITS, JOINTS, LANDMARKS, SessionHeader, Topic, digit_of
from sessions.records.topics import (
    EVENTS,
    HAND_POSE,
    MARKERS,
    PATIENT_POSE,
    PHASE,
    REFERENCE,
    ROBOT_COMMAND,
    ROBOT_STATE,
)

TIPS = [LANDMARKS.index(f"{digit}_tip") for digit in DIGITS]
DRIVEN = ("index_mcp_flexion", "index_pip", "middle_mcp_flexion", "middle_pip")
START_NS = 5_000_000_000


@dataclass
class MemoryRecording:
    """What ``sessions.store.SessionReader`` shows, without a file."""

    header: SessionHeader
    sha256: str
    topics: dict[str, dict[str, Any]] = field(default_factory=dict)

    @property
    def counts(self) -> Mapping[str, int]:
        return {name: len(rows["t_ns"]) for name, rows in self.topics.items()}

    def columns(self, topic: Topic) -> Mapping[str, Any]:
        return self.topics[topic.name]

    def without(self, topic: Topic) -> MemoryRecording:
        return replace(self, topics={name: rows for name, rows in self.topics.items() if name != topic.name})


def header(kind: Any, **changes: Any) -> SessionHeader:
    return SessionHeader(
        **{
            "session_id": "0123456789abcdef" * 2,
            "kind": kind,
            "subject_id": "P-0001",
            "side": "right",
            "exercise": "index curl",
            "source": "virtual-camera",
            "software_version": "0.1.0",
            "utc_start_ns": 1_790_000_000_000_000_000,
            "monotonic_start_ns": START_NS,
            **changes,
        }
    )


def minimum_jerk(tau: Any) -> Any:
    tau = np.clip(tau, 0.0, 1.0)
    return 10 * tau**3 - 15 * tau**4 + 6 * tau**5


def curl(t_s: Any, *, period_s: float = 3.0, start_s: float = 0.5) -> Any:
    """0 at rest, 1 closed: 1 s closing, .5 s hold, 1 s opening, .5 s rest, over and over."""
    inside = np.maximum(t_s - start_s, 0.0) % period_s
    return np.where(t_s < start_s, 0.0, minimum_jerk(inside) - minimum_jerk(inside - 1.5))


def tips_of(joints_rad: Any) -> Any:
    return forward(average_hand(), joints_rad).landmarks_m[..., TIPS, :]


def joints_of(shape: Any, pip_rad: float) -> Any:
    joints = np.zeros((len(shape), len(JOINTS)))
    joints[:, JOINTS.index("index_pip")] = pip_rad * shape
    joints[:, JOINTS.index("index_mcp_flexion")] = 0.5 * pip_rad * shape
    return joints


@pytest.fixture
def make_take() -> Callable[..., MemoryRecording]:
    def make(
        *,
        pip_rad: float = np.deg2rad(40.0),
        repetitions: int = 3,
        noise_rad: float = 0.0,
        rate_hz: float = 60.0,
    ) -> MemoryRecording:
        rng = np.random.default_rng(7)
        t_s = np.arange(round((1.0 + 3.0 * repetitions) * rate_hz)) / rate_hz
        joints = joints_of(curl(t_s), pip_rad)
        joints = joints + rng.normal(0.0, noise_rad, joints.shape) if noise_rad else joints
        rows, sigma = len(t_s), max(noise_rad, np.deg2rad(0.5))
        status = np.full((rows, len(LANDMARKS)), 2, np.uint8)
        status[60:90, 0] = 0
        t_ns = START_NS + np.round(t_s * 1e9).astype(np.int64)
        return MemoryRecording(
            header("take", marker_names=LANDMARKS),
            "a1" * 32,
            {
                HAND_POSE.name: {
                    "t_ns": t_ns,
                    "joints_rad": joints,
                    "joint_covariance_rad2": np.tile(np.eye(21) * sigma**2, (rows, 1, 1)),
                    "joint_status": np.full((rows, 21), 2, np.uint8),
                    "fingertips_palm_m": tips_of(joints),
                    "fingertip_covariance_m2": np.tile(np.eye(3) * 0.0005**2, (rows, 5, 1, 1)),
                    "residual_m": np.full(rows, 0.0012),
                },
                MARKERS.name: {"t_ns": t_ns, "status": status},
            },
        )

    return make


PHASES = (("ramp", -1, 0.0), ("move", 0, 0.5), ("hold", 0, 3.0), ("rest", 0, 3.4))


@pytest.fixture
def make_session() -> Callable[..., MemoryRecording]:
    """A passive session of three repetitions: the patient's index PIP lags by a constant ``offset_rad``."""

    def make(
        *, offset_rad: float = np.deg2rad(3.0), repetitions: int = 3, stopped: bool = False
    ) -> MemoryRecording:
        rate, period = 100.0, 3.0
        t_s = np.arange(round((1.0 + period * repetitions) * rate)) / rate
        reference = joints_of(curl(t_s), np.deg2rad(40.0))
        patient = reference.copy()
        patient[:, JOINTS.index("index_pip")] -= offset_rad
        t_ns = START_NS + np.round(t_s * 1e9).astype(np.int64)
        status = np.full((len(t_s), 21), 1, np.uint8)
        status[:, [JOINTS.index(joint) for joint in DRIVEN]] = 2
        poses = {
            "t_ns": t_ns,
            "source": np.array(["encoder"] * len(t_s)),
            "joints_rad": patient,
            "joint_std_rad": np.full((len(t_s), 21), np.deg2rad(0.2)),
            "joint_status": status,
            "fingertips_palm_m": tips_of(patient),
            "fingertip_std_m": np.full((len(t_s), 5), 0.0003),
        }
        topics: dict[str, Any] = {
            PATIENT_POSE.name: poses,
            REFERENCE.name: {
                "t_ns": t_ns,
                "path_s": t_s,
                "joints_rad": reference,
                "fingertips_palm_m": tips_of(reference),
            },
            PHASE.name: phases(t_s, t_ns, repetitions, stopped),
            **robot(t_s, reference, patient),
            EVENTS.name: {
                "t_ns": t_ns[[10, -5]],
                "kind": np.array(["note", "stop"]),
                "cause": np.array(["comment", "e-stop"]),
                "category": np.array(["", "CAT1"]),
                "text": np.array(["Warm hand.", "The stop button was pressed."]),
            }
            if stopped
            else {"t_ns": t_ns[:0], "kind": [], "cause": [], "category": [], "text": []},
        }
        ordered = f'{{"mode": "passive", "repetitions": {repetitions}}}'
        return MemoryRecording(
            header("therapy", robot_joints=DRIVEN, prescription=ordered, source="exoskeleton"),
            "b2" * 32,
            topics,
        )

    return make


def phases(t_s: Any, t_ns: Any, repetitions: int, stopped: bool) -> dict[str, Any]:
    """Every 0.1 s: ramp until 0.5 s, then per repetition 2 s move, 0.6 s hold, 0.4 s rest; then done."""
    rows = slice(0, None, 10)
    since = t_s[rows] - 0.5
    index = np.floor(since / 3.0 + 1e-9).astype(int)
    within = since - 3.0 * index
    names = np.where(within < 2.0 - 1e-9, "move", np.where(within < 2.6 - 1e-9, "hold", "rest"))
    names = np.where(since < -1e-9, "ramp", np.where(index >= repetitions, "done", names)).astype("U8")
    count = len(names)
    if stopped:
        last = np.flatnonzero((index == repetitions - 1) & (within > 1.0))
        names[last[0] :] = "stopped"
    helped = np.full((count, 5), np.nan)
    helped[:, 1:3] = 3.0
    return {
        "t_ns": t_ns[rows],
        "repetition": np.where((names == "ramp") | (names == "done"), -1, index),
        "phase": names,
        "mode": np.array(["passive"] * count),
        "started_by": np.array(["robot"] * count),
        "assistance": helped,
    }


def robot(t_s: Any, reference: Any, patient: Any) -> dict[str, Any]:
    """Ticks of a robot that pulls a passive, elastic limb (0.05 Nm/rad) along."""
    columns = [JOINTS.index(joint) for joint in DRIVEN]
    t_fine = np.arange(round(t_s[-1] * 1000)) / 1000.0
    q = np.stack([np.interp(t_fine, t_s, patient[:, column]) for column in columns], axis=1)
    moved = q - q[0]
    t_ns = START_NS + np.round(t_fine * 1e9).astype(np.int64)
    shape = q.shape
    return {
        ROBOT_STATE.name: {
            "t_ns": t_ns,
            "q_rad": q,
            "dq_rad_s": np.gradient(q, 0.001, axis=0),
            "tau_interaction_nm": 0.05 * moved,
        },
        ROBOT_COMMAND.name: {"t_ns": t_ns, "stiffness_nm_rad": np.full(shape, 0.9)},
    }


def joints_of_digit(digit: str) -> list[str]:
    return [joint for joint in JOINTS if digit_of(joint) == digit]
