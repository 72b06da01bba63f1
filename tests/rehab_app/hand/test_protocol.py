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
        ("[-0.01, 0.0, 0.0]", "[-0.01, 0.0]", "own.toml"),
        ('anchor = "wrist"', "", "own.toml"),
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


def test_unknown_names_are_refused_with_the_known_ones() -> None:
    with pytest.raises(Refused, match="thesis25"):
        load_protocol("thesis26")
