"""Every real recording becomes a take, and every number of its report has an interval or says why not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rehab_app.recording.importers import ImportedTake, import_recording
from rehab_app.recording.importers.leap_text import read_document
from sessions.metrics import measure_file
from sessions.metrics.metric import Metric
from sessions.metrics.registry import definition

_FRAMES = 130  # of a longer recording, the first

_RECORDINGS = {
    "HandSplay-110fps": "right",
    "confidence-37fps": "left",
    "grab": "right",
    "pinch-57fps": "right",
    "rollAndPitchCropped": "right",
    "wave": "right",
}


def leap(shared_data: Path, folder: Path, name: str, side: str) -> ImportedTake:
    """The beginning of a real recording."""
    document = read_document(shared_data / "leap_recordings" / f"{name}.json.lz")
    path = folder / f"{name}.json"
    path.write_text(json.dumps({"frames": document["frames"][:_FRAMES]}))
    return import_recording(path, side)


def mocap(shared_data: Path, folder: Path) -> ImportedTake:
    """The first five seconds of the motion capture."""
    lines = (shared_data / "mocap_hand_dfki" / "recording.tsv").read_text("utf-8-sig").splitlines()
    first = next(row for row, line in enumerate(lines) if line.startswith("MARKER_NAMES")) + 1
    head = [line if not line.startswith("NO_OF_FRAMES") else "NO_OF_FRAMES\t500" for line in lines[:first]]
    path = folder / "mocap.tsv"
    path.write_text("\n".join((*head, *lines[first : first + 502])))
    return import_recording(path, "right")


def unexplained(metric: Metric) -> bool:
    """Whether a number has neither an interval nor a reason."""
    return metric.interval is None and metric.status == "ok" and not definition(metric.name).exact


@pytest.mark.parametrize(("name", "side"), _RECORDINGS.items())
def test_a_recording_becomes_a_take_that_is_measured(
    shared_data: Path, tmp_path: Path, name: str, side: str
) -> None:
    taken = leap(shared_data, tmp_path, name, side if name.startswith("confidence") else "")
    assert (taken.side, taken.source) == (side, "leap-motion")
    assert taken.residual_m < 0.0015
    assert 0.15 < taken.subject.geometry.length_m < 0.20
    reported(taken, tmp_path)


def test_the_motion_capture_is_measured(shared_data: Path, tmp_path: Path) -> None:
    reported(mocap(shared_data, tmp_path), tmp_path)


def reported(taken: ImportedTake, folder: Path) -> None:
    sealed = taken.write(folder / "take.mcap", exercise="recorded", software_version="0")
    metrics = measure_file(sealed.path).metrics
    assert len(metrics) > 100
    assert [metric for metric in metrics if unexplained(metric)] == []
    assert all(metric.unit and metric.version and metric.lineage.source == taken.source for metric in metrics)
