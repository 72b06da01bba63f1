"""What a browser may say to a viewport: an allow-list.

The viewport's server trusts its clients: one message may set any attribute of any control, open a tunnel to
the internet or upload files. So each message is decoded here and only what a picture needs is let through,
built anew from the fields that were checked.
"""

from __future__ import annotations

import math
from typing import Any

import msgspec

LARGEST_MESSAGE = 8 * 1024
_LONGEST_TEXT = 200
_MOST_NUMBERS = 16
_CAMERA = "ViewerCameraMessage"
_CONTROL = "GuiUpdateMessage"
_CAMERA_SIZES = {
    "wxyz": 4,
    "position": 3,
    "look_at": 3,
    "up_direction": 3,
    "fov": 0,
    "near": 0,
    "far": 0,
    "image_height": 0,
    "image_width": 0,
}


def let_through(raw: bytes, controls: bool) -> bytes | None:
    """The message to forward, None where it is dropped.

    Args:
        raw: One message of a browser, msgpack.
        controls: Whether this person may move the viewport's controls (sliders, check boxes).
    """
    if len(raw) > LARGEST_MESSAGE:
        return None
    try:
        said: Any = msgspec.msgpack.decode(raw)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
    if not isinstance(said, dict):
        return None
    kept = _kept(said, controls)
    return None if kept is None else msgspec.msgpack.encode(kept)


def _kept(said: dict[Any, Any], controls: bool) -> dict[str, Any] | None:
    kind = said.get("type")
    if kind == _CAMERA:
        return _camera(said)
    if kind == _CONTROL and controls:
        return _control(said)
    return None


def _camera(said: dict[Any, Any]) -> dict[str, Any] | None:
    """Where somebody looks from: exactly the known fields, finite numbers of the known sizes."""
    kept: dict[str, Any] = {"type": _CAMERA}
    for name, size in _CAMERA_SIZES.items():
        value = said.get(name)
        fits = _is_number(value) if size == 0 else _is_vector(value, size)
        if not fits:
            return None
        kept[name] = value
    return kept


def _control(said: dict[Any, Any]) -> dict[str, Any] | None:
    """A control's ``value`` and nothing else: not ``removed``, not ``disabled``, not its text."""
    uuid, updates = said.get("uuid"), said.get("updates")
    if not isinstance(uuid, str) or len(uuid) > _LONGEST_TEXT or not isinstance(updates, dict):
        return None
    if list(updates) != ["value"] or not _is_value(updates["value"]):
        return None
    return {"type": _CONTROL, "uuid": uuid, "updates": {"value": updates["value"]}}


def _is_value(value: Any) -> bool:
    if isinstance(value, str):
        return len(value) <= _LONGEST_TEXT
    if isinstance(value, list):
        return len(value) <= _MOST_NUMBERS and all(_is_number(item) for item in value)
    return isinstance(value, bool) or _is_number(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _is_vector(value: Any, size: int) -> bool:
    return isinstance(value, list) and len(value) == size and all(_is_number(item) for item in value)
