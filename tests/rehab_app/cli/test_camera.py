"""``rehab-app camera`` through the real command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app


def run(*arguments: object, code: int = 0) -> tuple[dict[str, Any], str]:
    result = CliRunner().invoke(app, ["camera", *(str(item) for item in arguments)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == code, result.output
    assert "Traceback" not in result.output
    return json.loads(result.stdout or "{}"), result.stderr


def video(path: Path, value: int) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (160, 120))
    for _ in range(30):
        writer.write(np.full((120, 160, 3), value, np.uint8))
    writer.release()
    return path


def test_listing_says_what_is_there() -> None:
    content, _ = run("list", "--json")
    assert content["cameras"][0] == {
        "id": "virtual",
        "label": "Virtual camera",
        "state": "ready",
        "has_depth": True,
        "remedy": "",
    }
    alone, said = run()
    assert alone == {}
    assert "virtual" in said
    assert run("--json")[0] == content


def test_a_preview_shows_the_markers_it_found(tmp_path: Path) -> None:
    out = tmp_path / "look.png"
    content, said = run("preview", "virtual", "--seconds", 0.2, "--out", out, "--json")
    assert content["frames"] == 7
    assert content["rate_hz"] == pytest.approx(30.0)
    assert (content["width_px"], content["height_px"]) == (640, 480)
    assert content["markers"] == 25
    assert content["depth_share"] > 0.9
    assert content["fault"] is None
    assert content["picture"] == str(out)
    picture = cv2.imread(str(out))
    assert picture.shape == (480, 640, 3)
    ringed = (picture == (90, 220, 60)).all(axis=2)
    assert ringed.sum() > 25 * 20
    assert "25 blue markers" in said
    assert [path.name for path in tmp_path.iterdir()] == ["look.png"]


def test_without_depth_it_says_what_is_lost(tmp_path: Path) -> None:
    content, said = run("preview", video(tmp_path / "a.avi", 120), "--out", tmp_path / "a.jpg", "--json")
    assert content["has_depth"] is False
    assert content["depth_share"] is None
    assert "no depth" in said
    assert "without distances" in said


def test_black_and_white_pictures_are_named(tmp_path: Path) -> None:
    for value in (0, 255):
        source = video(tmp_path / f"{value}.avi", value)
        content, said = run("preview", source, "--out", tmp_path / "a.png", "--json")
        assert content["fault"]
        assert content["fault"] in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("preview", "webcam:987"), "not found"),
        (("preview", "nonsense"), "video:FILE"),
        (("preview", "absent.mp4"), "is absent"),
        (("preview", "virtual", "--seconds", "-1"), "0.1 to 60 s"),
        (("preview", "virtual", "--out", "look.gif"), "PNG or JPEG"),
        (("preview", "virtual", "--seconds", "0.1", "--out", "absent/look.png"), "not usable"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    content, said = run(*arguments, "--json", code=1)
    assert words in content["error"]["message"]
    assert " ".join(said.split()).endswith(content["error"]["message"])
    assert list(tmp_path.iterdir()) == []
