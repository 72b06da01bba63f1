"""Takes of the virtual camera beside its truth: how often the intervals of their numbers hold it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rehab_app.cameras import virtual_camera
from rehab_app.hand.protocol import load_protocol
from rehab_app.services.recording_request import PROTOCOL, RecordingRequest
from rehab_app.services.take_sources import CYCLE_S, Listeners, record_take
from robot_iface.kinematics import forward
from sessions.metrics import Summary, measure, measure_file
from sessions.metrics.honest import SHARES
from sessions.records import DIGITS, LANDMARKS, SessionHeader, Topic
from sessions.records.topics import HAND_POSE
from sessions.store import SessionReader

SECONDS = 8.0
TIPS = [LANDMARKS.index(f"{digit}_tip") for digit in DIGITS]


@dataclass(frozen=True)
class TrueRecording:
    """A take whose angles and tips are the true ones."""

    header: SessionHeader
    rows: Mapping[str, Any]
    sha256: str = "0" * 64

    @property
    def counts(self) -> Mapping[str, int]:
        return {HAND_POSE.name: len(self.rows["t_ns"])}

    def columns(self, topic: Topic) -> Mapping[str, Any]:
        assert topic == HAND_POSE
        return self.rows


def covered(folder: Path, moves: Iterable[str], seeds: Iterable[int]) -> dict[str, tuple[int, int]]:
    """By metric: how many intervals hold the truth, and of how many."""
    counts: dict[str, tuple[int, int]] = dict.fromkeys(SHARES, (0, 0))
    for exercise in moves:
        for seed in seeds:
            measured, true = beside_truth(folder, exercise, seed)
            for item in measured.metrics:
                other = true.metric(item.name, item.subject)
                if item.name not in counts or item.interval is None or other is None or not other.measurable:
                    continue
                held, number = counts[item.name]
                low, high = item.interval
                counts[item.name] = (held + int(low <= other.value <= high), number + 1)
    return counts


def beside_truth(folder: Path, exercise: str, seed: int) -> tuple[Summary, Summary]:
    """The numbers of a take, and those of the movement that it was made of."""
    path = folder / f"{exercise}-{seed}.mcap"
    request = RecordingRequest(exercise=exercise, side="right", seconds=SECONDS, seed=seed)
    record_take(request, path, calibrations=(None,), subject=None, listeners=Listeners())
    with SessionReader(path) as reader:
        rows, header = dict(reader.columns(HAND_POSE)), reader.header
    protocol = load_protocol(PROTOCOL)
    camera = virtual_camera(exercise, "right", SECONDS, protocol, seed=seed, period_s=CYCLE_S)
    joints = camera.truth_joints_rad((rows["t_ns"] - header.monotonic_start_ns) * 1e-9)
    tips = forward(camera.scene.worn.geometry, joints).landmarks_m[:, TIPS]
    true = measure(TrueRecording(header, {**rows, "joints_rad": joints, "fingertips_palm_m": tips}))
    return measure_file(path), true
