"""From camera to report on both robots, by the command line alone: modes, sides, another hand, every file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app
from sessions.store import SessionReader

SMALL_M = 0.165


def run(data: Path, *arguments: object) -> dict[str, Any]:
    result = CliRunner().invoke(app, [*(str(item) for item in arguments), "--data", str(data), "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.fixture(scope="module")
def clinic(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A clinic folder with a small left hand on record, and an approved take of a right hand."""
    data = tmp_path_factory.mktemp("clinic")
    take = run(data, "record", "--exercise", "index_pip", "--seconds", "3", "--seed", "41")["id"]
    run(data, "approve", take, "--by", "anna")
    person = ("--given", "Bo", "--family", "Li", "--birth-date", "1960-01-31", "--side", "left")
    run(data, "patient", "add", *person, "--hand-length", SMALL_M)
    return data, take


@pytest.mark.parametrize(
    ("mode", "robot", "kind"),
    [
        ("passive", "dlr-hit-ii", "healthy"),
        ("assistive", "exoskeleton", "slacking"),
        ("resistive", "exoskeleton", "healthy"),
    ],
)
def test_every_mode_is_played_verified_and_reported(
    clinic: tuple[Path, str], mode: str, robot: str, kind: str
) -> None:
    data, take = clinic
    order = ("--mode", mode, "--robot", robot, "--virtual-patient", kind, "--speed", "1", "--seed", "3")
    played = run(data, "play", take, *order, "--repetitions", "1", "--patient", "P-0001")
    assert played["completed"]
    assert played["stops"] == []
    assert played["reason"] == "repetitions"
    assert len(played["repetitions"]) == 1
    assert run(data, "verify", played["session"])["ok"]
    assert run(data, "info", played["session"])["side"] == "left"
    with SessionReader(Path(played["session"])) as session:
        assert session.counts["/tf"] > 100
    assert run(data, "report", played["session"])["metrics"]


def test_the_same_run_has_the_same_digest(clinic: tuple[Path, str]) -> None:
    data, take = clinic
    order = ("--virtual-patient", "tremor", "--speed", "1", "--repetitions", "1", "--seed", "7")
    first, again = (run(data, "play", take, *order)["digest"] for _ in range(2))
    assert first == again
