"""The target of a grasp as a file keeps it: what was to be grasped, how, and in which posture.

It stands in the header's ``prescription`` under the name ``target``: in the take that was made of a computed
grasp, and in every session that played it, so that a review can show what was aimed at.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from rehab_app.errors import Refused
from rehab_app.grasp.grip import GRIPS
from rehab_app.grasp.objects import Box, Cylinder, Sphere, Thing

_NAME = "target"


@dataclass(frozen=True, slots=True)
class StoredTarget:
    """A target grip.

    Attributes:
        thing: The object.
        grip: transverse or diagonal.
        angles_rad: The posture by name of the joint, rad.
    """

    thing: Thing
    grip: str
    angles_rad: dict[str, float]


def target_to_json(target: StoredTarget) -> str:
    """The target as a JSON object with the one member ``target``."""
    content = {"object": _of_thing(target.thing), "grip": target.grip, "angles_rad": target.angles_rad}
    return json.dumps({_NAME: content})


def with_target(prescription: str, take_prescription: str) -> str:
    """A session's prescription, with the target of the take that it plays where that has one.

    Args:
        prescription: JSON object of what was prescribed.
        take_prescription: What the header of the take says; empty for a recorded one.
    """
    target = _member(take_prescription)
    return prescription if target is None else json.dumps({**json.loads(prescription), _NAME: target})


def target_from_json(prescription: str) -> StoredTarget | None:
    """The target in a header's prescription; None where there is none that can be read."""
    content = _member(prescription)
    if content is None:
        return None
    try:
        grip = str(content["grip"])
        angles = {str(name): float(angle) for name, angle in content["angles_rad"].items()}
        thing = _thing_of(content["object"])
    except (KeyError, TypeError, ValueError, AttributeError, Refused):
        return None
    known = grip in GRIPS and all(math.isfinite(angle) for angle in angles.values())
    return StoredTarget(thing, grip, angles) if known else None


def _member(text: str) -> dict[str, Any] | None:
    try:
        content: Any = json.loads(text)
    except ValueError:
        return None
    found: Any = content.get(_NAME) if isinstance(content, dict) else None
    return found if isinstance(found, dict) else None


def _of_thing(thing: Thing) -> dict[str, object]:
    if isinstance(thing, Box):
        return {"kind": "box", "depth_m": thing.depth_m, "width_m": thing.width_m}
    return {"kind": "sphere" if isinstance(thing, Sphere) else "cylinder", "radius_m": thing.radius_m}


def _thing_of(content: dict[str, Any]) -> Thing:
    """The object.

    Raises:
        KeyError: Its kind is unknown, or a size is missing.
        ValueError: A size is no number.
        Refused: A size is no object's.
    """
    kind = content["kind"]
    if kind == "box":
        return Box(float(content["depth_m"]), float(content["width_m"]))
    return {"sphere": Sphere, "cylinder": Cylinder}[kind](float(content["radius_m"]))
