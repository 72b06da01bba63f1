"""The allow-list of what a browser may say to a viewport."""

from __future__ import annotations

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from viser import _messages

from rehab_app.web.gateway.messages import LARGEST_MESSAGE, let_through

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.1, 0.2, 0.3],
    "fov": 0.8,
    "near": 0.01,
    "far": 100,
    "image_height": 800,
    "image_width": 600,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}
VALUE = {"type": "GuiUpdateMessage", "uuid": "u", "updates": {"value": 0.5}}


def sent(message, controls=True):
    kept = let_through(msgspec.msgpack.encode(message), controls)
    return None if kept is None else msgspec.msgpack.decode(kept)


def test_a_camera_and_a_value_pass():
    assert sent(CAMERA) == CAMERA
    assert sent(CAMERA, controls=False) == CAMERA
    for value in (0.5, 3, True, "Palm", [1, 2.5]):
        message = {**VALUE, "updates": {"value": value}}
        assert sent(message) == message


def test_controls_need_the_role():
    assert sent(VALUE, controls=False) is None


@pytest.mark.parametrize(
    "updates",
    [
        {"removed": True},
        {"disabled": False},
        {"value": 1, "removed": True},
        {},
        None,
        [],
        {"value": {"a": 1}},
        {"value": None},
        {"value": b"x"},
        {"value": "x" * 999},
        {"value": [[1]]},
        {"value": list(range(99))},
        {"value": math.nan},
        {"value": math.inf},
    ],
)
def test_only_a_plain_value_of_a_control_passes(updates):
    assert sent({**VALUE, "updates": updates}) is None


def test_every_other_message_of_the_viewport_is_dropped():
    kinds = {kind.__name__ for kind in _messages.Message.get_subclasses()}
    assert {"ShareUrlRequest", "FileTransferPart", "RunJavascriptMessage"} <= kinds
    for kind in kinds - {"ViewerCameraMessage", "GuiUpdateMessage"}:
        assert sent({**CAMERA, **VALUE, "type": kind}) is None


def test_a_camera_is_rebuilt_from_known_fields():
    assert sent({**CAMERA, "excluded_self_client": 3, "x": 1}) == CAMERA
    for name in CAMERA.keys() - {"type"}:
        assert sent({**CAMERA, name: math.nan}) is None
        assert sent({**CAMERA, name: "x"}) is None
        assert sent({key: value for key, value in CAMERA.items() if key != name}) is None


def test_size_is_bounded():
    assert let_through(b"\xc4" * (LARGEST_MESSAGE + 1), True) is None


@given(st.binary(max_size=200))
def test_no_bytes_make_it_fail(raw):
    assert let_through(raw, True) is None or msgspec.msgpack.decode(raw)["type"]


def test_deep_nesting_is_dropped():
    assert let_through(b"\x91" * 8000 + b"\x01", True) is None
