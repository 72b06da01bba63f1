from __future__ import annotations

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from rehab_app.calibration import CalibratedCamera, Placement, load_camera, save_camera
from rehab_app.calibration.board_pose import matrix_of
from rehab_app.errors import Refused
from rehab_app.geometry.lens import Lens
from rehab_app.geometry.pinhole import Intrinsics

PLAIN = {"fx": 525.0, "fy": 524.0, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480}
SIX = Intrinsics(525.0, 524.0, 319.5, 239.5, 640, 480)


def whole():
    place = Placement("left", matrix_of(np.array([0.1, 0.2, 0.3])), np.array([0.1, 0.0, -0.2]), 0.2)
    return CalibratedCamera(
        camera="webcam:0",
        intrinsics=SIX,
        lens=Lens((-0.28, 0.09, 0.001, -0.001, 0.0)),
        method="chessboard",
        rms_px=0.19,
        verdict="good",
        placement=place,
        world=replace(place, reference="world"),
        colour='{"name": "blue", "share": [0.5, 0.25]}',
    ).now()


def test_a_file_gives_back_what_was_saved(tmp_path):
    camera = whole()
    path = save_camera(camera, tmp_path / "left.json")
    again = load_camera(path)
    assert again.digest == camera.digest == json.loads(path.read_text())["digest"]
    assert again.table() == camera.table()
    assert [item.name for item in tmp_path.iterdir()] == ["left.json"]


def test_the_digest_tells_versions_apart():
    camera = whole()
    others = [
        replace(camera, camera="webcam:1"),
        replace(camera, intrinsics=replace(SIX, fx_px=525.0001)),
        replace(camera, lens=Lens((-0.28, 0.09, 0.001, -0.001, 1e-9))),
        replace(camera, placement=None),
        replace(camera, colour=""),
        replace(camera, created_utc="2026-01-01T00:00:00Z"),
    ]
    assert len({one.digest for one in (camera, *others)}) == 7


def test_a_changed_file_is_refused(tmp_path):
    path = save_camera(whole(), tmp_path / "left.json")
    path.write_text(path.read_text().replace("525.0", "535.0"))
    with pytest.raises(Refused, match="changed since it was made"):
        load_camera(path)
    table = json.loads(path.read_text())
    del table["digest"]
    path.write_text(json.dumps(table))
    assert load_camera(path).intrinsics.fx_px == 535.0


@pytest.mark.parametrize(
    "table",
    [
        PLAIN,
        {f"{key}_px": value for key, value in PLAIN.items()},
        {"intrinsics": PLAIN},
        {**PLAIN, "ppx": 1.0, "coeffs": [0, 0, 0, 0, 0], "model": "distortion.brown_conrady"},
        {"camera_matrix": [[525, 0, 319.5], [0, 524, 239.5], [0, 0, 1]], "image_size": [640, 480]},
        {"K": [525, 0, 319.5, 0, 524, 239.5, 0, 0, 1], "width": 640, "height": 480, "D": []},
    ],
)
def test_plain_files_of_other_programs(tmp_path, table):
    (tmp_path / "cam.json").write_text(json.dumps(table))
    camera = load_camera(tmp_path / "cam.json")
    assert camera.intrinsics == SIX
    assert camera.lens.straight
    assert camera.verdict == "unknown"


def test_a_plain_file_may_say_where_the_camera_stands(tmp_path):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = matrix_of(np.array([0.0, 3.0, 0.0])), (0.1, 0.2, 0.3)
    (tmp_path / "cam.json").write_text(json.dumps({**PLAIN, "T_tracking_camera": matrix.tolist()}))
    view = load_camera(tmp_path / "cam.json").view(1)
    assert view.index == 1
    assert np.allclose(view.rotation_tracking_camera, matrix[:3, :3])
    assert np.allclose(view.p_tracking_camera_m, (0.1, 0.2, 0.3))


def test_files_of_opencv_and_ros(tmp_path, shared_data):
    camera = load_camera(shared_data / "chessboard_stereo" / "left_intrinsics.yml")
    assert camera.intrinsics.fx_px == pytest.approx(535.9157)
    assert camera.lens.coefficients[0] == pytest.approx(-0.26637, abs=1e-5)
    assert camera.rms_px == pytest.approx(0.3926, abs=1e-3)
    for suffix in ("yml", "xml"):
        storage = cv2.FileStorage(str(tmp_path / f"c.{suffix}"), cv2.FILE_STORAGE_WRITE)
        storage.write("camera_matrix", np.array([[525, 0, 319.5], [0, 524, 239.5], [0, 0, 1.0]]))
        storage.write("distortion_coefficients", np.array([0.1, -0.2, 0.0, 0.0, 0.0]))
        storage.write("image_width", 640)
        storage.write("image_height", 480)
        storage.release()
        found = load_camera(tmp_path / f"c.{suffix}")
        assert found.intrinsics == SIX
        assert found.lens.coefficients == (0.1, -0.2, 0.0, 0.0, 0.0)
    (tmp_path / "ros.yaml").write_text(
        "image_width: 640\nimage_height: 480\ncamera_name: narrow\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
        "  data: [525.0, 0.0, 319.5, 0.0, 524.0, 239.5, 0.0, 0.0, 1.0]\ndistortion_model: plumb_bob\n"
        "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, -0.2, 0.0, 0.0, 0.0]\n"
    )
    found = load_camera(tmp_path / "ros.yaml")
    assert (found.camera, found.intrinsics) == ("narrow", SIX)
    assert found.lens.coefficients == (0.1, -0.2, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"fx": float("nan")}, "fx in cam.json"),
        ({"fx": None}, "fx in cam.json is missing"),
        ({"fy": "wide"}, "fy in cam.json is 'wide'"),
        ({"fx": -525.0}, "above 0 px"),
        ({"width": 0}, "above 0 px"),
        ({"width": 640.5}, "whole pixels"),
        ({"width": 10**7, "height": 10**7}, "at most"),
        ({"cx": 639.5, "cy": 359.5}, "for images of 640 x 480"),
        ({"fx": 20.0, "fy": 20.0}, "fx = 20 px for images of 640 x 480"),
        ({"fx": 250.0}, "nearly the same"),
        ({"distortion": [1, 2]}, ""),
        ({"distortion": ["a"]}, "a list of numbers"),
        ({"distortion": [float("inf"), 0, 0, 0]}, "lens distortion"),
        ({"distortion": [0.1] * 12}, "12 coefficients"),
        ({"distortion_model": "equidistant"}, "distortion model of cam.json"),
        ({"T_world_camera": [[1, 2], [3, 4]]}, "4 x 4 numbers"),
        ({"T_world_camera": np.ones((4, 4)).tolist()}, "rigid pose"),
    ],
)
def test_nonsense_is_one_sentence(tmp_path, change, sentence):
    (tmp_path / "cam.json").write_text(json.dumps({**PLAIN, **change}))
    if not sentence:
        assert load_camera(tmp_path / "cam.json").lens.coefficients == (1.0, 2.0, 0.0, 0.0)
        return
    with pytest.raises(Refused) as refusal:
        load_camera(tmp_path / "cam.json")
    assert sentence in str(refusal.value)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.json", b"{"),
        ("a.json", b"[1, 2]"),
        ("a.json", b"\xff\xfe\x00garbage"),
        ("a.json", b"[" * 100_000),
        ("a.json", b'{"format": "rehab-app camera calibration", "format_version": 1}'),
        ("a.json", b'{"format": "rehab-app camera calibration", "format_version": 99}'),
        ("a.yml", b""),
        ("a.yml", b"a: b: [c"),
        ("a.xml", b"<?xml version='1.0'?><a>"),
        ("a.yaml", b"%YAML:1.0\n---\ncamera_matrix: 3\n"),
    ],
)
def test_files_that_are_no_calibration(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(Refused):
        load_camera(tmp_path / name)


def test_places_that_cannot_be_read_or_written(tmp_path):
    for path in (tmp_path / "none.json", tmp_path):
        with pytest.raises(Refused, match="no file"):
            load_camera(path)
    for path in (tmp_path / "a.txt", tmp_path / "none" / "a.json"):
        with pytest.raises(Refused):
            save_camera(whole(), path)
