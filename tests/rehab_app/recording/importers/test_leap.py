"""Leap Motion recordings: a made hand comes back in either layout; damaged ones are refused in a sentence."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.recording.importers import import_recording, leap_text
from rehab_app.recording.importers.leap import NAMES, read_leap
from rehab_app.recording.importers.leap_text import unpress
from sessions.errors import Refused
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64
from sessions.store import SessionReader
from tests.rehab_app.recording.importers.conftest import closing_hand, markers

FRAMES = 60
_LEAP_FROM_CAMERA = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
_KEYS = ("mcpPosition", "pipPosition", "dipPosition", "tipPosition")


def pressed(text: str) -> str:
    """Text as lz-string's ``compressToBase64`` would press it: the inverse, written apart."""
    table: dict[str, int] = {}
    bits: list[str] = []
    size, width, room, before, at = 3, 2, 1, "", 0

    def put(value: int, count: int) -> None:
        bits.append(format(value, f"0{count}b")[::-1])

    def grow() -> None:
        nonlocal size, width, room
        size, room = size + 1, room - 1
        if not room:
            room, width = 1 << width, width + 1

    while at < len(text):
        known = table | ({before + before[0]: size} if before else {})
        phrase = text[at]
        while phrase in known and at + len(phrase) < len(text) and phrase + text[at + len(phrase)] in known:
            phrase += text[at + len(phrase)]
        if phrase in known:
            put(known[phrase], width)
        else:
            put(0 if ord(phrase) < 256 else 1, width)
            put(ord(phrase), 8 if ord(phrase) < 256 else 16)
            table[phrase] = size
            grow()
        if before:
            table.setdefault(before + phrase[0], size)
            grow()
        before, at = phrase, at + len(phrase)
    put(2, width)
    held = "".join(bits)
    held += "0" * (-len(held) % 8)
    return base64.b64encode(bytes(int(held[at : at + 8], 2) for at in range(0, len(held), 8))).decode()


def plain(points_m: Float64, side: Side = "right", rate_hz: float = 50.0) -> dict[str, Any]:
    """A recording of one hand, each frame an object."""
    rows = 1e3 * points_m @ _LEAP_FROM_CAMERA.T
    frames = [
        {
            "id": 7 + number,
            "timestamp": 5_000_000 + round(1e6 * number / rate_hz),
            "hands": [{"id": 4, "type": side}],
            "pointables": [
                {"handId": 4, "id": 40 + digit, "tool": False, "type": digit}
                | {key: row[4 * digit + at].tolist() for at, key in enumerate(_KEYS)}
                for digit in range(5)
            ],
        }
        for number, row in enumerate(rows)
    ]
    return {"metadata": {"formatVersion": 1}, "frames": frames}


def packed(document: dict[str, Any]) -> dict[str, Any]:
    """The same in rows of values, without the type of a digit."""
    hand, digit = ["id", "type"], ["id", "handId", "tool", *_KEYS]
    rows = [
        [
            frame["id"],
            frame["timestamp"],
            [[one[key] for key in hand] for one in frame["hands"]],
            [[one[key] for key in digit] for one in frame["pointables"]],
        ]
        for frame in document["frames"]
    ]
    return document | {"frames": [["id", "timestamp", {"hands": [hand]}, {"pointables": [digit]}], *rows]}


@pytest.fixture(scope="module")
def hand_m() -> Float64:
    return markers("leap20", "right", FRAMES)


def written(path: Path, document: Any) -> Path:
    text = json.dumps(document)
    path.write_text(pressed(text) if path.suffix == ".lz" else text)
    return path


def test_a_text_that_the_library_itself_pressed() -> None:
    assert unpress("BYUwNmD2A0AECWsCGBbZtDUzkA==", 100) == "hello, i am a 猫"


@pytest.mark.parametrize("text", ["a", "aaaaaaaaaaaaaaaaaa", "abab" * 50, "{}[]\x00\xff猫", "é" * 300])
def test_pressed_text_comes_back(text: str) -> None:
    assert unpress(pressed(text), 1000) == text


def test_random_text_comes_back() -> None:
    rng = np.random.default_rng(5)
    for letters in (2, 40, 3000):
        text = "".join(chr(48 + code) for code in rng.integers(0, letters, 4000))
        assert unpress(pressed(text), 4000) == text


@pytest.mark.parametrize("layout", [plain, lambda points_m: packed(plain(points_m))])
@pytest.mark.parametrize("name", ["a.json.lz", "a.json"])
def test_points_come_back_in_either_layout(
    tmp_path: Path, hand_m: Float64, layout: Callable[[Float64], Any], name: str
) -> None:
    recorded, side = read_leap(written(tmp_path / name, layout(hand_m)), None)
    assert (side, recorded.source, recorded.series.names) == ("right", "leap-motion", NAMES)
    np.testing.assert_allclose(recorded.series.p_camera_m, hand_m, atol=1e-9)
    np.testing.assert_allclose(recorded.series.t_s, np.arange(FRAMES) / 50.0, atol=1e-9)


def test_a_hand_that_leaves_is_a_gap_and_the_pose_returns(tmp_path: Path, hand_m: Float64) -> None:
    document = plain(hand_m)
    for frame in document["frames"][20:25]:
        frame.update(hands=[], pointables=[])
    taken = import_recording(written(tmp_path / "wave.json", document), "")
    assert taken.protocol is not None
    assert (taken.protocol.name, taken.side, taken.landmarks, taken.gaps) == ("leap20", "right", 20, 20)
    assert taken.residual_m < 0.002
    bend = taken.fit.joints_rad[:, JOINTS.index("index_pip")]
    seen = taken.series.seen.all(axis=1)
    truth = closing_hand(FRAMES)[:, JOINTS.index("index_pip")]
    assert np.median(np.abs(bend - truth)[seen]) < np.deg2rad(3)
    sealed = taken.write(tmp_path / "wave.mcap", exercise="wave", software_version="0")
    with SessionReader(sealed.path) as reader:
        assert (reader.header.source, reader.header.marker_protocol) == ("leap-motion", "leap20")


def test_of_two_hands_the_side_chooses(tmp_path: Path, hand_m: Float64) -> None:
    document = plain(hand_m)
    other = plain(hand_m * [-1, 1, 1], "left")
    for frame, beside in zip(document["frames"], other["frames"], strict=True):
        frame["hands"] += [one | {"id": 9} for one in beside["hands"]]
        frame["pointables"] += [one | {"handId": 9} for one in beside["pointables"]]
    path = written(tmp_path / "two.json", document)
    with pytest.raises(Refused, match=r"both hands.*--side left or --side right"):
        import_recording(path, "")
    left, side = read_leap(path, "left")
    assert side == "left"
    np.testing.assert_allclose(left.series.p_camera_m, hand_m * [-1, 1, 1], atol=1e-9)


def change(at: int, **values: Any) -> Callable[[dict[str, Any]], Any]:
    def changed(document: dict[str, Any]) -> Any:
        document["frames"][at].update(values)
        return document

    return changed


def tip(value: Any) -> Callable[[dict[str, Any]], Any]:
    def changed(document: dict[str, Any]) -> Any:
        document["frames"][3]["pointables"][1]["tipPosition"] = value
        return document

    return changed


BOTH = [{"id": 4, "type": "right"}, {"id": 5, "type": "right"}]


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda _: [], "without frames"),
        (lambda _: {"frames": []}, "without frames"),
        (lambda _: {"frames": 3}, "without frames"),
        (lambda _: {"frames": [{}, 3]}, "do not agree"),
        (lambda _: {"frames": [["id"], ["a", "b"]]}, "do not agree"),
        (lambda _: {"frames": [[3], [3]]}, "do not agree"),
        (lambda _: {"frames": [["id"]]}, "0 frames"),
        (lambda _: {"frames": [[{"hands": [["id"]]}], [3]]}, "without the hands"),
        (lambda _: {"frames": [{}, {}]}, "without the hands"),
        (lambda good: {"frames": good["frames"][:10]}, "0.5 s or longer"),
        (lambda good: {"frames": [one | {"hands": []} for one in good["frames"]]}, "without a hand"),
        (change(5, timestamp=5_000_000), "rising"),
        (change(5, timestamp="soon"), "without the hands"),
        (change(5, timestamp=None), "without the hands"),
        (change(5, timestamp=10**400), "without the hands"),
        (change(5, hands=[{"id": 4, "type": "foot"}]), "without the hands"),
        (change(5, hands=BOTH), "two right hands"),
        (change(5, pointables=[{"handId": 4, "id": 49, "tool": False}]), "without the hands"),
        (tip([1.0, 2.0]), "without the hands"),
        (tip("here"), "without the hands"),
        (tip([1.0, 2.0, float("nan")]), "finite"),
        (tip([1.0, 2.0, 1e9]), "100 m"),
    ],
)
def test_a_damaged_recording_is_refused_in_one_sentence(
    tmp_path: Path, hand_m: Float64, spoil: Callable[[dict[str, Any]], Any], says: str
) -> None:
    path = written(tmp_path / "bad.json", spoil(plain(hand_m)))
    with pytest.raises(Refused) as refusal:
        import_recording(path, "")
    assert says in str(refusal.value)
    assert str(refusal.value).count("\n") == 0


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda good: good[: len(good) // 2], "cut or damaged"),
        (lambda good: "====", "cut or damaged"),
        (lambda good: "not base64!", "not pressed by lz-string"),
        (lambda good: "\x00\x01", "not pressed by lz-string"),
        (lambda good: "/" * 400, "cut or damaged"),
        (lambda good: pressed("[" * 5000), "no whole JSON"),
        (lambda good: pressed('{"frames": '), "no whole JSON"),
        (lambda good: pressed('{"frames": Infinity}'), "finite"),
    ],
)
def test_a_damaged_file_is_refused_in_one_sentence(
    tmp_path: Path, hand_m: Float64, spoil: Callable[[str], str], says: str
) -> None:
    path = tmp_path / "bad.json.lz"
    path.write_text(spoil(pressed(json.dumps(plain(hand_m[:3])))))
    with pytest.raises(Refused, match=says):
        import_recording(path, "")


def test_what_grows_without_bound_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "bomb.json.lz"
    path.write_text(pressed("a" * 20_000))
    assert path.stat().st_size < 1000
    monkeypatch.setattr(leap_text, "MOST_LETTERS", 10_000)
    with pytest.raises(Refused, match="longer than 10000 letters"):
        import_recording(path, "")
    monkeypatch.setattr(leap_text, "MOST_PRESSED_BYTES", 100)
    with pytest.raises(Refused, match="at most 100 bytes"):
        import_recording(path, "")


def test_a_side_that_is_not_there_and_a_text_that_is_none(tmp_path: Path, hand_m: Float64) -> None:
    path = written(tmp_path / "right.json", plain(hand_m))
    with pytest.raises(Refused, match="of the right hand only"):
        import_recording(path, "left")
    path.write_bytes(b"\xff\xfe\xfd")
    with pytest.raises(Refused, match="no text"):
        import_recording(path, "")
