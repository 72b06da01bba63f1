"""Colours: named, learnt from a click, found; kept as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from rehab_app.cameras import Frame, Truth, paper_markers, virtual_camera
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.hand.protocol import load_protocol
from rehab_app.vision import COLOURS, ContrastDetector, colour_from_json, colour_to_json, named_colour
from rehab_app.vision.colour import ColourModel, tint
from rehab_app.vision.colour_learning import find_colour, learn_colour, learn_patch
from sessions.errors import Refused

INKS = {
    "blue": (196, 92, 34),
    "green": (70, 150, 45),
    "red": (45, 40, 200),
    "yellow": (35, 205, 235),
    "black": (34, 34, 34),
    "pink": (170, 120, 235),
    "cyan": (200, 190, 30),
}


def scene(
    monkeypatch: pytest.MonkeyPatch, ink: tuple[int, ...], ring_m: float = 0.008
) -> tuple[Frame, Truth]:
    """An open hand that wears markers of some ink."""
    monkeypatch.setattr(paper_markers, "_BLUE_BGR", np.array(ink, np.float32))
    monkeypatch.setattr(paper_markers, "RING_RADIUS_M", ring_m)
    camera = virtual_camera("open_close", "right", 6.0, load_protocol("thesis25"), seed=6)
    return camera.frame(5), camera.truth(5 / 30)


def found(frame: Frame, model: ColourModel, truth: Truth) -> tuple[int, int]:
    """Markers found, and false detections."""
    seen = ContrastDetector(model).detect(0, frame.colour_bgr, frame.depth_m, frame.intrinsics)
    apart = np.linalg.norm(truth.pixel_px[:, None] - seen.pixel_px, axis=2)
    return int((apart.min(axis=1) < 1.0).sum()), int((apart.min(axis=0) > 4.0).sum())


@pytest.mark.parametrize("name", ["blue", "green", "red", "yellow", "black"])
def test_a_named_colour_finds_its_markers(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    frame, truth = scene(monkeypatch, INKS[name])
    right, wrong = found(frame, named_colour(name), truth)
    assert right >= 24
    assert wrong <= 1


@pytest.mark.parametrize("name", INKS)
def test_a_click_and_a_look_learn_any_colour(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    frame, truth = scene(monkeypatch, INKS[name])
    marker = int(np.argmax(truth.markers.facing()))
    u, v = (float(edge) for edge in truth.pixel_px[marker] + 0.8)
    for model in (
        learn_colour(frame.colour_bgr, (u, v)),
        learn_colour(frame.colour_bgr, (u, v), 4.0),
        find_colour(frame.colour_bgr, frame.depth_m, frame.intrinsics),
        find_colour(frame.colour_bgr, None, frame.intrinsics),
    ):
        assert model.ring
        right, wrong = found(frame, model, truth)
        assert right >= 23
        assert wrong <= 1


def test_a_found_colour_has_the_nearest_name(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("green", "red", "black"):
        frame, _ = scene(monkeypatch, INKS[name])
        assert find_colour(frame.colour_bgr, frame.depth_m, frame.intrinsics).name == name


def test_stickers_without_a_ring_are_learnt_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    frame, truth = scene(monkeypatch, INKS["green"], ring_m=0.006)
    marker = int(np.argmax(truth.markers.facing()))
    u, v = (float(edge) for edge in truth.pixel_px[marker])
    model = learn_colour(frame.colour_bgr, (u, v))
    assert not model.ring
    right, wrong = found(frame, model, truth)
    assert right >= 22
    assert wrong <= 2


def test_a_patch_teaches_like_a_click(monkeypatch: pytest.MonkeyPatch) -> None:
    frame, truth = scene(monkeypatch, INKS["red"])
    marker = int(np.argmax(truth.markers.facing()))
    u, v = (round(float(edge)) for edge in truth.pixel_px[marker])
    model = learn_patch(frame.colour_bgr[v - 14 : v + 15, u - 14 : u + 15], name="mine")
    assert model.name == "mine"
    assert found(frame, model, truth)[0] >= 23


def test_clicks_beside_a_marker_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    frame, _ = scene(monkeypatch, INKS["blue"])
    with pytest.raises(Refused, match="within 640 x 480"):
        learn_colour(frame.colour_bgr, (700.0, 10.0))
    with pytest.raises(Refused, match="disc"):
        learn_colour(frame.colour_bgr, (100.0, 60.0))  # the wall
    with pytest.raises(Refused, match="1 to 40 px"):
        learn_colour(frame.colour_bgr, (300.0, 200.0), 90.0)
    with pytest.raises(Refused, match="8 x 8"):
        learn_patch(frame.colour_bgr[:5, :5])


def test_a_picture_without_markers_has_no_colour_to_find() -> None:
    frame = virtual_camera("open_close", "right", 6.0, load_protocol("thesis25"), seed=6).frame(0)
    bare = np.full_like(frame.colour_bgr, 120)
    with pytest.raises(Refused, match="click on a marker"):
        find_colour(bare, frame.depth_m, frame.intrinsics)


@pytest.mark.parametrize("name", COLOURS)
def test_json_keeps_a_model_whole(name: str) -> None:
    model = named_colour(name)
    assert colour_from_json(colour_to_json(model)) == model
    assert model.shares.sum() == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(
    "change",
    [
        {"weights_bgr": [1.0, 2.0]},
        {"weights_bgr": [0, 0, 0]},
        {"weights_bgr": [1, 0, 0]},
        {"histogram": [1.0]},
        {"darkness": "much"},
        {"ink_bgr": [float("nan"), 0, 0]},
    ],
)
def test_broken_json_is_refused(change: dict[str, object]) -> None:
    table = {**json.loads(colour_to_json(named_colour("blue"))), **change}
    with pytest.raises(Refused, match="colour model"):
        colour_from_json(json.dumps(table))
    with pytest.raises(Refused, match="colour model"):
        colour_from_json("no json")


@pytest.mark.parametrize("name", [name for name in COLOURS if name != "black"])
@pytest.mark.parametrize("light", [0.5, 1.0])
def test_tint_parts_ink_from_paper_and_skin_whatever_the_light(name: str, light: float) -> None:
    model = named_colour(name)
    colours = np.array([model.ink_bgr, (238, 238, 238), (118, 152, 205), (60, 85, 135)])
    image = np.rint(colours * light).astype(np.uint8)[None]
    ink, *rest = tint(image, model)[0]
    assert ink - max(rest) > 0.15
    assert abs(rest[0]) < 0.01


def test_a_bare_hand_teaches_no_colour(shared_data: Path) -> None:
    video = cv2.VideoCapture(str(shared_data / "human_hand_video" / "human_hand_video.mp4"))
    good, picture = video.read()
    video.release()
    assert good
    camera = Intrinsics(920.0, 920.0, 639.5, 359.5, 1280, 720)
    with pytest.raises(Refused, match="marker colour"):
        find_colour(np.asarray(picture, np.uint8), None, camera)
    seen = ContrastDetector().detect(0, np.asarray(picture, np.uint8), None, camera)
    assert len(seen) <= 2
