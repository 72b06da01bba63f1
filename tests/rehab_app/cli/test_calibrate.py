"""``rehab-app calibrate`` through the real command line."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app

BOARD = ("--board", "9x6", "--square", "0.025")


@pytest.fixture
def run(tmp_path):
    def call(*arguments, code=0):
        words = ["calibrate", *[str(item) for item in arguments], "--json"]
        result = CliRunner().invoke(app, words, env={"REHAB_DATA": str(tmp_path / "clinic")})
        assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
        assert result.exit_code == code, result.output
        assert "Traceback" not in result.output
        return json.loads(result.stdout), result.stderr

    return call


@pytest.fixture
def refused(run):
    def call(*arguments):
        content, said = run(*arguments, code=1)
        error = content["error"]
        assert set(error) == {"thing", "value", "bound", "remedy", "message"}
        assert " ".join(said.split()).endswith(error["message"])
        return error["message"]

    return call


@pytest.fixture
def pair(shared_data):
    return shared_data / "chessboard_stereo"


def test_a_camera_from_its_images_to_the_clinic(run, pair, tmp_path):
    out = tmp_path / "left.json"
    images = sorted(pair.glob("left*.jpg"))
    made, said = run("intrinsics", *images, *BOARD, "--id", "webcam:0", "--out", out)
    assert made["rms_px"] <= 0.25
    assert made["fx_px"] == pytest.approx(532.8, abs=1.5)
    assert (made["verdict"], made["kept"], len(made["views"])) == ("good", True, 13)
    assert "Good:" in said
    listed, _ = run("list")
    assert [row["digest"] for row in listed["calibrations"]] == [made["digest"]]
    for named in (out, "webcam:0", made["digest"][:12]):
        shown, _ = run("show", named)
        assert (shown["digest"], shown["camera"]) == (made["digest"], "webcam:0")
    stands, _ = run("world", pair / "left01.jpg", *BOARD, "--camera-intrinsics", made["digest"][:12])
    assert stands["world"]["reference"] == "world"
    assert stands["world"]["p_m"][2] > 0.2
    assert run("show", "webcam:0")[0]["digest"] == stands["digest"]


def test_two_cameras_beside_each_other(run, pair, tmp_path):
    made, said = run(
        *("stereo", "--images", pair / "left*.jpg", "--images", pair / "right*.jpg", *BOARD),
        *("--id", "left", "--id", "right", "--out", tmp_path),
    )
    assert made["rms_px"] <= 0.25
    assert made["baseline_m"] == pytest.approx(0.0832, abs=5e-4)
    assert made["kept"]
    assert "83.2" in said
    right = json.loads((tmp_path / "right.json").read_text())
    assert right["placement"]["reference"] == "left"
    assert right["placement"]["p_m"][0] == pytest.approx(0.0832, abs=5e-4)
    again, _ = run(
        *("stereo", "--images", pair / "left*.jpg", "--images", pair / "right*.jpg", *BOARD),
        *("--camera-intrinsics", tmp_path / "left.json", "--camera-intrinsics", tmp_path / "right.json"),
    )
    assert again["baseline_m"] == pytest.approx(made["baseline_m"], abs=1e-6)


def test_a_board_to_print(run, tmp_path):
    made, said = run("board", "--out", tmp_path / "board.pdf", "--board", "charuco:7x5")
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")
    assert made["page_m"] == [0.297, 0.21]
    assert "100 %" in said


def test_the_colour_of_the_markers(run, refused, tmp_path):
    plain = tmp_path / "plain.json"
    plain.write_text(
        json.dumps({"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480})
    )
    image = np.full((480, 640, 3), (140, 170, 215), np.uint8)
    cv2.circle(image, (300, 200), 14, (250, 250, 250), -1, cv2.LINE_AA)
    cv2.circle(image, (300, 200), 9, (60, 160, 40), -1, cv2.LINE_AA)
    cv2.imwrite(str(tmp_path / "hand.png"), image)
    picture = ("--camera-intrinsics", plain, "--image", tmp_path / "hand.png")
    made, _ = run("colour", *picture, "--at", "300,200")
    blue, green, red = made["colour"]["ink_bgr"]
    assert green > max(blue, red) + 50
    assert made["kept"]
    assert "click" in refused("colour", *picture, "--at", "9999,5")
    assert "--at" in refused("colour", *picture, "--at", "here")


def test_bad_input_is_one_sentence(run, refused, pair, tmp_path):
    cv2.imwrite(str(tmp_path / "blank.png"), np.full((480, 640), 128, np.uint8))
    left = sorted(pair.glob("left*.jpg"))
    for number, path in enumerate(left[:3]):
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        cv2.imwrite(str(tmp_path / f"large{number}.png"), cv2.resize(image, (1280, 960)))
    large = sorted(tmp_path.glob("large*.png"))
    assert "no contrast" in refused("intrinsics", tmp_path / "blank.png", *BOARD)
    assert "1 of 1" in refused("intrinsics", left[0], *BOARD)
    assert "but one of 9 x 6" in refused("intrinsics", *left[:3], "--board", "9x7", "--square", "0.025")
    assert "25 m" in refused("intrinsics", left[0], "--board", "9x6", "--square", "25")
    assert "1280 x 960" in refused("intrinsics", *left[:3], *large, *BOARD)
    assert "not there" in refused("intrinsics", tmp_path / "none", *BOARD)
    assert "missing" in refused("intrinsics", *BOARD)
    assert "given twice" in refused("intrinsics", left[0], "--camera", "virtual", *BOARD)
    assert "camera list" in refused("intrinsics", "--camera", "teapot", *BOARD)
    known = ("--camera-intrinsics", pair / "left_intrinsics.yml")
    assert "1280 x 960" in refused("world", large[0], *BOARD, *known)
    assert "in none of the images" in refused("world", tmp_path / "blank.png", *BOARD, *known)
    assert "number of cameras" in refused("stereo", "--images", pair / "left*.jpg", *BOARD)
    assert "no file" in refused("show", tmp_path / "none.json")
    assert "unknown" in refused("show", "webcam:7")
    assert "does not exist" in refused("board", "--out", tmp_path / "none" / "b.pdf")
    assert run("list")[0]["calibrations"] == []


def test_what_is_to_be_redone_is_not_kept(run, pair, tmp_path):
    made, said = run(
        "intrinsics", *sorted(pair.glob("left*.jpg"))[:3], *BOARD, "--out", tmp_path / "few.json"
    )
    assert (made["verdict"], made["kept"]) == ("redo", False)
    assert made["why"]
    assert "Not kept" in said
    assert json.loads((tmp_path / "few.json").read_text())["verdict"] == "redo"
    assert run("list")[0]["calibrations"] == []
