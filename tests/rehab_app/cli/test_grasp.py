"""``rehab-app grasp`` through the real command line."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app
from rehab_app.recording.importers import import_recording


def run(*arguments: object, code: int = 0) -> tuple[dict[str, Any], str]:
    result = CliRunner().invoke(app, ["grasp", *(str(item) for item in arguments), "--json"])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == code, result.output
    return json.loads(result.stdout), result.stderr


def test_the_thesis_posture_of_the_robot() -> None:
    content, said = run(
        *(
            "--object",
            "cylinder:radius=0.0225",
            "--hand",
            "dlr-hit-ii",
            "--grip",
            "transverse",
            "--method",
            "thesis",
        )
    )
    assert content["z_m"] == pytest.approx(-0.007262, abs=1e-6)
    assert content["alpha_rad"] == pytest.approx(-0.178914, abs=1e-5)
    assert set(content["radius_m"]) == {"thumb", "index", "middle", "ring", "little"}
    assert set(content["radius_m"]["thumb"]) == {"mcp", "ip"}
    assert set(content["radius_m"]["index"]) == {"pip", "dip"}
    assert content["penetration_m"] == pytest.approx(0.0177, abs=1e-3)
    assert any("cuts" in warning for warning in content["warnings"])
    assert "alpha -10.251 deg" in said


def test_a_person_with_path_and_picture(tmp_path: Path) -> None:
    picture = tmp_path / "grip.svg"
    content, _ = run(
        *("--object", "cylinder:radius=0.03", "--hand", "human:length=0.189", "--side", "left"),
        *("--grip", "diagonal", "--path", "--plot", picture),
    )
    assert content["side"] == "left"
    assert content["penetration_m"] <= 1e-5
    assert {at["digit"] for at in content["contacts"]} >= {"palm", "index", "little"}
    path = content["path"]
    assert len(path["s"]) == len(path["joints_rad"]["index_pip"]) == 101
    assert path["joints_rad"]["ring_pip"][-1] == pytest.approx(content["angles_rad"]["ring_pip"], abs=1e-12)
    root = ElementTree.parse(picture).getroot()
    assert root.tag.endswith("svg")
    assert len(root.findall(".//{*}line")) == 31


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("cylinder:radius=0", "human"), "is 0 m, but must be above 0 m"),
        (("cylinder:radius=-0.01", "human"), "is -0.01 m, but must be above 0 m"),
        (("cylinder:radius=inf", "human"), "is inf m, but must be above 0 m and at most 10 m"),
        (("cylinder:radius=nan", "human"), "is nan m, but must be above 0 m"),
        (("sphere:radius=-inf", "human"), "is -inf m, but must be above 0 m"),
        (("box:depth=nan,width=0.05", "human"), "box depth is nan m"),
        (("box:depth=0.04", "human"), "box:depth=D,width=W"),
        (("box:depth=0.2,width=0.2", "human"), "must be at least 118 deg"),
        (("cylinder:radius=0.03,radius=0.04", "human"), "each size once"),
        (("cylinder:radius=0.002", "human"), r"is 0.002 m (grip is not possible"),
        (("cylinder:radius=0.15", "human"), "reaches 33 deg around"),
        (("cylinder:radius=0.005", "dlr-hit-ii", "--method", "thesis"), "PIP angle is 1.764 rad"),
        (("cylinder:radius=0.03", "human:length=nan"), "hand length is nan m, but must be 0.10 to 0.26 m"),
        (("cylinder:radius=0.03", "human", "--dip-per-pip", "nan"), "is nan, but must be 0 to 1.5"),
        (("cylinder:radius=0.03", "human", "--dip-per-pip", "9"), "is 9, but must be 0 to 1.5"),
        (("cylinder:radius=0.03", "human", "--alpha-rad", "2"), "is 2 rad, but must be -1.047 to 1.047 rad"),
        (("cylinder:radius=0.03", "human", "--method", "magic"), "contact or thesis"),
        (("sphere:radius=0.03", "dlr-hit-ii", "--method", "thesis"), "use method contact"),
        (("cylinder:radius=0.03", "human", "--side", "middle"), "left or right"),
        (("cylinder:radius=0.03", "dlr-hit-ii", "--subject", "x.mcap"), "use --hand human"),
        (("cylinder:radius=0.03", "human", "--subject", "missing.mcap"), "a take that exists"),
        (("cylinder:radius=0.03", "human", "--take", "x.txt"), "ends in .mcap"),
        (("cylinder:radius=big", "human"), "name=number"),
        (("teapot", "human"), "cylinder:radius=R"),
        (("cylinder:radius=0.03", "human:length=3"), "0.10 to 0.26 m"),
        (("cylinder:radius=0.03", "claw"), "dlr-hit-ii or human"),
        (("cylinder:radius=0.4", "dlr-hit-ii"), "for this hand"),
        (("cylinder:radius=0.0225", "dlr-hit-ii", "--alpha-rad", "nan"), "inclination"),
        (("cylinder:radius=0.0225", "dlr-hit-ii", "--grip", "hook"), "transverse or diagonal"),
        (("cylinder:radius=0.0225", "dlr-hit-ii", "--side", "left"), "a right hand"),
        (("cylinder:radius=0.0225", "human", "--plot", "grip.exe"), ".svg"),
        (("sphere:radius=0.02", "dlr-hit-ii", "--grip", "pinch"), "--hand human"),
        (("sphere:radius=0.02", "human", "--grip", "pinch", "--path"), "without"),
    ],
)
def test_bad_input_is_a_sentence(arguments: tuple[str, ...], words: str) -> None:
    thing, hand, *rest = arguments
    content, said = run("--object", thing, "--hand", hand, *rest, code=1)
    message = content["error"]["message"]
    assert words in message
    assert "\n" not in message
    assert "Traceback" not in said


@pytest.mark.parametrize(("radius_m", "hand"), [("0.002", "human:length=0.17"), ("0.15", "dlr-hit-ii")])
def test_the_range_that_a_refusal_names_is_the_range_that_holds(radius_m: str, hand: str) -> None:
    content, _ = run("--object", f"cylinder:radius={radius_m}", "--hand", hand, code=1)
    named = re.search(r"must be (\S+) to (\S+) m for this hand", content["error"]["message"])
    assert named is not None
    low_m, high_m = float(named[1]), float(named[2])
    assert low_m < high_m
    for inside_m in (low_m + 1e-4, high_m - 1e-4):
        run("--object", f"cylinder:radius={inside_m:.6f}", "--hand", hand)


def test_the_shape_of_the_hand_in_a_take(tmp_path: Path) -> None:
    rows = ["0," * 21 + "0"] * 30 + [",".join(["40"] * 22)] * 30
    recording = tmp_path / "glove.csv"
    recording.write_text("\n".join(rows) + "\n")
    take = import_recording(recording, "right").write(
        tmp_path / "take.mcap", exercise="grasp", software_version="0"
    )
    content, said = run("--shape", take.path)
    assert content["repetitions"] == 1
    assert content["aperture_rad"]["sd"] is None
    assert "aperture" in said
    assert run("--shape", take.path, "--shape", take.path)[0]["aperture_rad"]["sd"] == pytest.approx(
        0, abs=1e-9
    )
    assert "given alone" in run("--shape", take.path, "--hand", "human", code=1)[1]
    assert "--object is missing" in run("--hand", "human", code=1)[1]


def test_a_grasp_becomes_a_take_that_can_be_approved(tmp_path: Path) -> None:
    take = tmp_path / "grasp.mcap"
    content, said = run("--object", "cylinder:radius=0.03", "--hand", "human", "--take", take)
    assert Path(content["take"]) == take
    assert "rehab-app approve" in said
    assert "path" not in content
    assert run("--shape", take)[0]["repetitions"] == 1
    again, _ = run("--object", "cylinder:radius=0.03", "--hand", "human", "--take", take, code=1)
    assert "grasp.mcap" in again["error"]["message"]
    words = run("--object", "cylinder:radius=0.02", "--hand", "dlr-hit-ii", "--take", "b.mcap", code=1)[1]
    assert "--hand human" in words


def test_the_hand_reaches_for_a_cylinder_and_holds_it(tmp_path: Path) -> None:
    picture = tmp_path / "reach.svg"
    content, said = run("--reach", "0.02", "--plot", picture)
    assert content["holds"] is True
    assert 0 < content["moved_m"]["gravity"] <= content["moved_m"]["worst_push"] < 0.005
    assert content["arm_error_m"]["largest"] < 0.002
    assert "holds the cylinder" in said
    assert ElementTree.parse(picture).getroot().tag.endswith("svg")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--reach", "0.09"), "for this hand"),
        (("--reach", "nan"), "is nan m, but must be above 0 m"),
        (("--reach", "0"), "above 0 m"),
        (("--reach", "-0.02"), "above 0 m"),
        (("--reach", "inf"), "at most 10 m"),
        (("--reach", "0.02", "--hand", "human"), "given alone"),
        (("--reach", "0.02", "--plot", "x.png"), ".svg"),
        (("--reproduce", "x.txt"), ".md"),
        (("--reproduce", "x.md", "--reach", "0.02"), "given together"),
        (("--reproduce", "x.md", "--plot", "x.svg"), "given alone"),
    ],
)
def test_trials_out_of_bounds_are_a_sentence(arguments: tuple[str, ...], words: str) -> None:
    content, said = run(*arguments, code=1)
    assert words in content["error"]["message"]
    assert "Traceback" not in said


def test_the_thesis_is_reproduced_by_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rehab_app.grasp.thesis_document.thesis_document", lambda: "# all of it\n")
    document = tmp_path / "thesis.md"
    content, _ = run("--reproduce", document)
    assert document.read_text() == "# all of it\n"
    assert [Path(file).name for file in content["files"]] == ["thesis.md", "figure-5.12.svg"]
    assert ElementTree.parse(tmp_path / "figures" / "figure-5.12.svg").getroot().tag.endswith("svg")
