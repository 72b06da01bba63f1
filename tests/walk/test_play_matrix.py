"""Mode by robot by virtual patient: each run says who started, what it helped with and how it ended."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app

MODES_THAT_HELP = ("passive", "assistive")
MOST_RMSE_RAD = 0.6


def run(data: Path, *arguments: object) -> dict[str, Any]:
    result = CliRunner().invoke(app, [*(str(item) for item in arguments), "--data", str(data), "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def recorded(data: Path, exercise: str, seconds: float) -> str:
    take = run(data, "record", "--exercise", exercise, "--seconds", seconds, "--seed", "41")["id"]
    run(data, "approve", take, "--by", "anna")
    return take


@pytest.fixture(scope="module")
def clinic(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A clinic folder with one approved take."""
    data = tmp_path_factory.mktemp("clinic")
    return data, recorded(data, "index_pip", 3)


@pytest.mark.parametrize(
    ("mode", "robot", "kind", "started_by"),
    [
        ("passive", "exoskeleton", "mas2", "robot"),
        ("passive", "dlr-hit-ii", "weak", "robot"),
        ("assistive", "exoskeleton", "weak", "patient"),
        ("transparent", "exoskeleton", "healthy", "patient"),
        ("transparent", "dlr-hit-ii", "healthy", ""),
        ("resistive", "exoskeleton", "weak", "patient"),
    ],
)
def test_a_run_of_each_kind_says_what_happened(
    clinic: tuple[Path, str], mode: str, robot: str, kind: str, started_by: str
) -> None:
    data, take = clinic
    order = ("--mode", mode, "--robot", robot, "--virtual-patient", kind, "--speed", "1", "--seed", "3")
    played = run(data, "play", take, *order, "--repetitions", "1")
    assert played["completed"]
    assert played["stops"] == []
    assert played["reason"] == "repetitions"
    assert played["safety_state"] == "READY"
    assert played["mode"] == mode
    assert bool(played["assistance"]) == (mode == "assistive")
    (repetition,) = played["repetitions"]
    assert repetition["index"] == 0
    assert repetition["started_by"] == started_by
    helped = repetition["assistance"]
    if mode in MODES_THAT_HELP:
        assert all(0.0 < value <= 4.0 for value in helped)
    else:
        assert helped == [None] * 5
    shown = repetition["rmse_rad"]
    assert math.isfinite(shown)
    assert 0.0 <= shown < MOST_RMSE_RAD


@pytest.mark.parametrize("exercise", ["opposition"])
def test_an_exercise_of_the_thumb_keeps_its_clearance_and_is_played(
    clinic: tuple[Path, str], exercise: str
) -> None:
    """Its fingertips touch where it is recorded: 5 mm are kept where it is played."""
    data, _ = clinic
    take = recorded(data, exercise, 6)
    played = run(data, "play", take, "--repetitions", "1", "--speed", "1", "--seed", "3")
    assert played["completed"]
    assert played["stops"] == []
    (note,) = (note for note in played["notes"] if note.startswith("The thumb was led"))
    assert "thumb_cmc" in note
