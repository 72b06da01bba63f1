"""``track`` and ``record`` through the real command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from rehab_app.cameras.sequence import point_sequence
from rehab_app.cameras.sequence_file import write_detections_npz
from rehab_app.cli.app import app

FIGURES = {
    "frames",
    "dropped",
    "measured_share",
    "estimated_share",
    "lost_share",
    "residual_m",
    "ms_per_frame",
}


def run(*arguments: object, data: Path | None = None) -> Result:
    environment = {} if data is None else {"REHAB_DATA": str(data)}
    result = CliRunner().invoke(app, [str(item) for item in arguments], env=environment)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


@pytest.fixture(scope="module")
def points(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("points") / "points.npz"
    write_detections_npz(point_sequence("easy", 5, 60, side="left"), path)
    return path


@pytest.mark.parametrize(("out", "kind"), [("tracks.npz", "tracks"), ("take.mcap", "take")])
def test_detections_become_tracks_or_a_take(points: Path, tmp_path: Path, out: str, kind: str) -> None:
    result = run("track", points, "--out", tmp_path / out, "--side", "left", "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert said[kind] == str(tmp_path / out)
    assert (tmp_path / out).is_file()
    assert set(said) >= FIGURES
    assert said["frames"] == 60
    assert said["complaints"] == []
    assert "% measured" in result.stderr


def test_a_refusal_is_one_object_and_one_sentence(points: Path, tmp_path: Path) -> None:
    with np.load(points) as given:
        content = {name: given[name] for name in given if name != "u_px"}
    np.savez(tmp_path / "cut.npz", **content)
    result = run("track", tmp_path / "cut.npz", "--out", tmp_path / "tracks.npz", "--json")
    assert result.exit_code == 1
    error = json.loads(result.stdout)["error"]
    assert set(error) == {"thing", "value", "bound", "remedy", "message"}
    assert error["remedy"] == "add u_px"
    assert "Traceback" not in result.output
    assert not (tmp_path / "tracks.npz").exists()
    assert run("track", points).exit_code == 2


def test_a_recording_keeps_the_hand_of_a_known_person(tmp_path: Path) -> None:
    arguments = ("record", "--exercise", "still", "--seconds", "1.5", "--subject", "T-7", "--json")
    result = run(*arguments, data=tmp_path)
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert said["dropped"] == 0
    assert said["measured_share"] > 0.9
    assert said["complaints"] == []
    from rehab_app.bootstrap import open_clinic

    with open_clinic(tmp_path) as clinic:
        kept = clinic.hands.list("T-7")
        assert [(one.side, one.protocol) for one in kept] == [("right", "thesis25")]
    assert run(*arguments, data=tmp_path).exit_code == 0


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--camera", "toaster", "webcam:0"),
        ("--camera", "webcam:77", "webcam:77"),
        ("--subject", "Anna Nowak", "never a name"),
        ("--protocol", "nothing", "thesis25"),
        ("--tracker", "magic", "rbmcda"),
        ("--seconds", "0.2", "another length"),
    ],
)
def test_a_recording_that_cannot_be_is_a_sentence(
    tmp_path: Path, option: str, value: str, words: str
) -> None:
    result = run("record", option, value, "--json", data=tmp_path)
    assert result.exit_code == 1
    assert words in json.loads(result.stdout)["error"]["message"]
    assert not list((tmp_path / "takes").glob("*")) if (tmp_path / "takes").exists() else True
