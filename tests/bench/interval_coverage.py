"""Takes of the virtual camera beside its truth: how often the intervals of their numbers hold it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rehab_app.cameras import virtual_camera
from rehab_app.hand.protocol import load_protocol
from rehab_app.services.recording_request import PROTOCOL, RecordingRequest
from rehab_app.services.take_sources import CYCLE_S, Listeners, record_take
from robot_iface.kinematics import forward
from sessions.metrics import Metric, Summary, measure, measure_file
from sessions.metrics.hand_motion import main_cycles, stroke_metrics
from sessions.metrics.honest import SHARES
from sessions.metrics.recording import Origin
from sessions.metrics.stroke_noise import NOISE_TAILS
from sessions.metrics.take import hand_motion
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


@dataclass(frozen=True, slots=True)
class Coverage:
    """How the intervals of one metric did.

    Attributes:
        held: How many hold the truth.
        number: Of how many.
        width: Sum of their widths, in the metric's unit.
        error: Sum of the distances from the truth.
    """

    held: int = 0
    number: int = 0
    width: float = 0.0
    error: float = 0.0

    def with_one(self, item: Metric, truth: float) -> Coverage:
        """One interval more."""
        low, high = item.interval or (item.value, item.value)
        held = self.held + int(low <= truth <= high)
        error = self.error + abs(item.value - truth)
        return Coverage(held, self.number + 1, self.width + high - low, error)

    def words(self, name: str) -> str:
        """A row of the table: metric, share held, number, mean width, mean error."""
        if not self.number:
            return f"{name}: none"
        share, width = 100.0 * self.held / self.number, self.width / self.number
        error = self.error / self.number
        return f"{name}: {share:.1f} % of {self.number}, mean width {width:.4g}, mean error {error:.3g}"


def covered(
    folder: Path,
    moves: Iterable[str],
    seeds: Iterable[int],
    names: Iterable[str] = tuple(SHARES),
    seconds: float = SECONDS,
) -> dict[str, Coverage]:
    """By metric: how the intervals of its numbers did, over all movements and seeds."""
    found = {name: Coverage() for name in names}
    for exercise in moves:
        for seed in seeds:
            measured, true = beside_truth(folder, exercise, seed, seconds)
            for item in measured.metrics:
                other = true.metric(item.name, item.subject) if item.name in found else None
                if item.interval is not None and other is not None and other.measurable:
                    found[item.name] = found[item.name].with_one(item, other.value)
    return found


def beside_truth(folder: Path, exercise: str, seed: int, seconds: float = SECONDS) -> tuple[Summary, Summary]:
    """The numbers of a take, and those of the movement that it was made of."""
    path = folder / f"{exercise}-{seed}.mcap"
    request = RecordingRequest(exercise=exercise, side="right", seconds=seconds, seed=seed)
    record_take(request, path, calibrations=(None,), subject=None, listeners=Listeners())
    with SessionReader(path) as reader:
        rows, header = dict(reader.columns(HAND_POSE)), reader.header
    protocol = load_protocol(PROTOCOL)
    camera = virtual_camera(exercise, "right", seconds, protocol, seed=seed, period_s=CYCLE_S)
    joints = camera.truth_joints_rad((rows["t_ns"] - header.monotonic_start_ns) * 1e-9)
    tips = forward(camera.scene.worn.geometry, joints).landmarks_m[:, TIPS]
    exact = {"fingertip_covariance_m2": np.zeros_like(rows["fingertip_covariance_m2"])}
    as_it_was = {**rows, **exact, "joints_rad": joints, "fingertips_palm_m": tips}
    true = measure(TrueRecording(header, as_it_was))
    strokes_s = main_cycles(hand_motion(rows)).strokes_s  # in a rest, where a stroke ends is anybody's guess
    of_strokes = stroke_metrics(hand_motion(as_it_was), strokes_s, Origin("0" * 64, header.source))
    others = [item for item in true.metrics if item.name not in NOISE_TAILS]
    return measure_file(path), replace(true, metrics=(*of_strokes, *others))
