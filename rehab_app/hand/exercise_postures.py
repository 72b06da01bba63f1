"""Postures of the library's exercises, as angles of the hand's 21 joints, and the movements between them."""

from __future__ import annotations

import numpy as np

from robot_iface.types import FINGERS, JOINTS
from sessions.errors import Refused
from sessions.records.fields import Float64

_STRAIGHT = {"index_mcp_abduction": 4.0, "ring_mcp_abduction": -4.0, "little_mcp_abduction": -8.0}
_THUMB_ASIDE = {"thumb_cmc_flexion": -8.0, "thumb_cmc_abduction": -18.0}


def _fingers(mcp: float, pip: float, dip: float) -> dict[str, float]:
    parts = {"mcp_flexion": mcp, "pip": pip, "dip": dip}
    return {f"{finger}_{part}": angle for finger in FINGERS for part, angle in parts.items()}


def _finger(name: str, mcp: float, pip: float, dip: float) -> dict[str, float]:
    return {f"{name}_mcp_flexion": mcp, f"{name}_pip": pip, f"{name}_dip": dip}


def _thumb(flexion: float, abduction: float, mcp: float, ip: float) -> dict[str, float]:
    return {
        "thumb_cmc_flexion": flexion,
        "thumb_cmc_abduction": abduction,
        "thumb_mcp_flexion": mcp,
        "thumb_ip": ip,
    }


_OPEN = {**_STRAIGHT, **_THUMB_ASIDE, **_fingers(3.0, 4.0, 2.0)}
_LOOSE = {**_thumb(6.0, -20.0, 20.0, 25.0), **_fingers(45.0, 55.0, 35.0)}
_ROUND = {**_thumb(6.0, -20.0, 16.0, 18.0), **_fingers(30.0, 40.0, 25.0)}
_TO_INDEX = {**_thumb(12.0, -23.0, 25.0, 25.0), **_finger("index", 44.0, 37.0, 20.0)}
_BENT_AWAY = {
    **_finger("middle", 55.0, 70.0, 45.0),
    **_finger("ring", 60.0, 75.0, 50.0),
    **_finger("little", 60.0, 75.0, 50.0),
}
POSTURES_DEG: dict[str, dict[str, float]] = {
    "open": _OPEN,
    "loose": _LOOSE,
    "straight fist": {**_THUMB_ASIDE, **_fingers(88.0, 98.0, 0.0)},
    "hook": {**_THUMB_ASIDE, **_fingers(0.0, 100.0, 65.0)},
    "fist": {**_thumb(6.0, -28.0, 50.0, 64.0), **_fingers(85.0, 100.0, 65.0)},
    "tabletop": {**_STRAIGHT, **_THUMB_ASIDE, **_fingers(85.0, 0.0, 0.0)},
    "index pip bent": {**_OPEN, "index_pip": 80.0, "index_dip": 12.0},
    "index tip bent": {**_OPEN, "index_dip": 60.0},
    "index bent": {**_OPEN, **_finger("index", 75.0, 85.0, 50.0)},
    "index tapped": {**_ROUND, "index_mcp_flexion": 58.0},
    "index lifted": {**_ROUND, **_finger("index", 5.0, 25.0, 15.0)},
    "closed": {
        **_fingers(3.0, 3.0, 2.0),
        **_THUMB_ASIDE,
        "index_mcp_abduction": -2.0,
        "little_mcp_abduction": 3.0,
    },
    "spread": {
        **_fingers(2.0, 3.0, 2.0),
        "thumb_cmc_abduction": -4.0,
        "thumb_cmc_flexion": -14.0,
        "index_mcp_abduction": 16.0,
        "middle_mcp_abduction": 2.0,
        "ring_mcp_abduction": -11.0,
        "little_mcp_abduction": -20.0,
    },
    "thumb beside": {**_OPEN, **_thumb(-8.0, -30.0, 5.0, 5.0)},
    "thumb forward": {**_OPEN, **_thumb(30.0, -10.0, 3.0, 3.0)},
    "thumb in palm": {**_OPEN, **_thumb(34.0, -24.0, 40.0, 45.0)},
    "thumb out": {**_OPEN, **_thumb(-22.0, -6.0, -2.0, -5.0)},
    "thumb to index": {**_OPEN, **_TO_INDEX},
    "thumb to middle": {**_OPEN, **_thumb(27.0, -24.0, 29.0, 25.0), **_finger("middle", 55.0, 42.0, 23.0)},
    "thumb to ring": {**_OPEN, **_thumb(35.0, -30.0, 41.0, 32.0), **_finger("ring", 68.0, 37.0, 16.0)},
    "ready to pinch": {**_OPEN, **_ROUND},
    "tip pinch": {**_BENT_AWAY, **_TO_INDEX},
    "three-jaw pinch": {
        **_thumb(18.0, -23.0, 29.0, 27.0),
        **_BENT_AWAY,
        **_finger("index", 55.0, 29.0, 13.0),
        **_finger("middle", 43.0, 51.0, 27.0),
    },
    "ready for a key": {**_fingers(55.0, 75.0, 48.0), **_thumb(-22.0, -8.0, 0.0, 0.0)},
    "key pinch": {**_fingers(55.0, 75.0, 48.0), **_thumb(-19.0, -25.0, 40.0, 40.0)},
    "ready to grasp": {**_STRAIGHT, **_fingers(18.0, 20.0, 10.0), **_thumb(12.0, -4.0, 0.0, 5.0)},
    "cylinder": {**_fingers(50.0, 55.0, 32.0), **_thumb(0.0, -12.0, 44.0, 40.0)},
    "wave start": {**_OPEN, **_finger("index", 60.0, 40.0, 20.0), **_finger("middle", 38.0, 25.0, 14.0)},
    "wave end": {**_OPEN, **_finger("little", 60.0, 40.0, 20.0), **_finger("ring", 38.0, 25.0, 14.0)},
}
"""Joints that a posture does not name are straight."""
MOVEMENTS: dict[str, tuple[str, ...]] = {
    "straight_fist": ("straight fist",),
    "hook_fist": ("hook",),
    "full_fist": ("fist",),
    "tabletop": ("tabletop",),
    "dip_blocking": ("index tip bent",),
    "finger_flexion": ("index bent",),
    "place_and_hold": ("loose",),
    "thumb_abduction": ("thumb forward",),
    "thumb_extension": ("thumb in palm", "thumb out"),
    "opposition": ("thumb to index", "thumb to middle", "thumb to ring"),
    "three_jaw_pinch": ("three-jaw pinch",),
    "key_pinch": ("ready for a key", "key pinch"),
    "cylinder_grasp": ("cylinder",),
    "wave": ("wave start", "wave end"),
}
"""Postures that a demonstration of an exercise visits, each from the open hand and back."""


def posture_rad(name: str) -> Float64:
    """Joint angles of a posture, shape (21,), rad.

    Raises:
        Refused: There is no posture of that name.
    """
    named = POSTURES_DEG.get(name)
    if named is None:
        raise Refused("posture", repr(name[:40]), "one of the library", "choose one of these")
    return np.deg2rad([named.get(joint, 0.0) for joint in JOINTS])
