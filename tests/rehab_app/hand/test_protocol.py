from __future__ import annotations

from pathlib import Path

import pytest

from rehab_app.hand.protocol import PROTOCOLS, SEGMENTS, load_protocol
from sessions.errors import Refused
from sessions.records import LANDMARKS

OWN = """
name = "own3"
[[marker]]
name = "a"
segment = "palm"
anchor = "wrist"
[[marker]]
name = "b"
segment = "index_distal"
anchor = "index_tip"
offset_m = [-0.01, 0.0, 0.0]
[[marker]]
name = "c"
segment = "palm"
anchor = "palm_1"
links = ["a"]
"""


@pytest.mark.parametrize("name", PROTOCOLS)
def test_built_in_protocols_hold_what_their_name_says(name: str) -> None:
    protocol = load_protocol(name)
    assert protocol.name == name
    assert len(protocol.markers) == int("".join(c for c in name if c.isdigit()))
    assert protocol.offsets_m.shape == protocol.offset_stds_m.shape == (len(protocol.markers), 3)
    assert all(marker.segment in SEGMENTS for marker in protocol.markers)


def test_the_thesis_has_one_marker_on_the_back_of_every_landmark() -> None:
    protocol = load_protocol("thesis25")
    assert set(protocol.names) == set(LANDMARKS)
    assert all(marker.name == marker.anchor and marker.offset_m[0] < 0 for marker in protocol.markers)


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    protocol = load_protocol(path)
    assert protocol.names == ("a", "b", "c")
    assert protocol.markers[2].links == ("a",)


@pytest.mark.parametrize(
    ("old", "new", "thing"),
    [
        ('name = "b"', 'name = "a"', "own3"),
        ('"index_distal"', '"index_claw"', "b"),
        ('"palm_1"', '"palm_9"', "c"),
        ('links = ["a"]', 'links = ["z"]', "c"),
        ("[-0.01, 0.0, 0.0]", "[-0.01, 0.0]", "own.toml, marker 2 (b), offset_m"),
        ("[-0.01, 0.0, 0.0]", '[-0.01, 0.0, "x"]', "own.toml, marker 2 (b), offset_m"),
        ("[-0.01, 0.0, 0.0]", "[-0.01, 0.0, nan]", "own.toml, marker 2 (b), offset_m"),
        ("[-0.01, 0.0, 0.0]", "[-10.0, 0.0, 0.0]", "own3, b, offset_m"),
        ('anchor = "wrist"', "", "own.toml, marker 1 (a), anchor"),
        ('anchor = "wrist"', 'anchor = "wrist"\ncolor = "blue"', "own.toml, marker 1 (a)"),
        ('anchor = "wrist"', 'anchor = "wrist"\noffset_std_m = [0.0, 0.1, 0.1]', "own3, a, offset_std_m"),
        ('links = ["a"]', 'links = "a"', "own.toml, marker 3 (c), links"),
        ('name = "own3"', 'name = "own3"\nmarkers = 3', "own.toml"),
        ('name = "own3"', "name = 3", "own.toml, name"),
        ('name = "own3"', 'name = "own3"\nnoise_m = "small"', "own.toml, noise_m"),
        ('name = "own3"', "name = ", "own.toml"),
        ('name = "own3"', 'name = "own3"\nnoise_m = -1.0', "own3"),
    ],
)
def test_a_broken_file_is_refused_by_name(tmp_path: Path, old: str, new: str, thing: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(OWN.replace(old, new, 1))
    with pytest.raises(Refused) as refusal:
        load_protocol(path)
    assert thing in refusal.value.thing


def test_the_example_of_the_manual_is_a_protocol(tmp_path: Path) -> None:
    manual = (Path(__file__).resolve().parents[3] / "docs" / "detection.md").read_text("utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(manual.split("```toml\n")[1].split("```")[0])
    assert load_protocol(path).names == ("index_pip", "index_dip", "index_tip")


def test_fewer_than_three_markers_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text("[[marker]]".join(OWN.split("[[marker]]")[:3]))
    with pytest.raises(Refused, match="of 2 markers, but must be 3 to 64"):
        load_protocol(path)
    path.write_text('name = "empty"')
    with pytest.raises(Refused, match="without markers"):
        load_protocol(path)


def test_one_finger_and_thumb_are_those_of_the_thesis() -> None:
    whole = {marker.name: marker for marker in load_protocol("thesis25").markers}
    few = load_protocol("finger_thumb8").markers
    assert {marker.segment.split("_")[0] for marker in few} == {"thumb", "index", "palm"}
    assert all(marker.offset_m == whole[marker.name].offset_m for marker in few)


def test_unknown_names_are_refused_with_the_known_ones() -> None:
    with pytest.raises(Refused, match="thesis25"):
        load_protocol("thesis26")
