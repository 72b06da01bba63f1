"""Numbers and names as a person reads them: degrees, millimetres, words. Files stay in SI units."""

from __future__ import annotations

import math
from collections.abc import Iterable

from sessions.metrics import Metric
from sessions.reports.language import _, decimal, marked

_SHOWN = {
    "rad": (180.0 / math.pi, "°", 1),
    "m": (1000.0, "mm", 1),
    "m/s": (1000.0, "mm/s", 0),
    "s": (1.0, "s", 2),
    "Hz": (60.0, marked("per min"), 1),
    "Nm": (1.0, "Nm", 3),
    "Nm/rad": (1.0, "Nm/rad", 2),
    "J": (1.0, "J", 3),
    "1": (1.0, "", 2),
}
_PERCENT = {"valid_share", "robot_share", "dose_completed"}
_COUNTS = {"repetitions", "repetitions_by_patient", "stops"}
MISSING = "—"
_SHORT = {"mcp", "pip", "dip", "cmc", "ip"}
_PARTS = {
    "mcp_flexion": marked("knuckle (MCP)"),
    "mcp_abduction": marked("knuckle, sideways (MCP abduction)"),
    "pip": marked("middle joint (PIP)"),
    "dip": marked("end joint (DIP)"),
    "cmc_flexion": marked("base (CMC flexion)"),
    "cmc_abduction": marked("base, sideways (CMC abduction)"),
    "ip": marked("end joint (IP)"),
}
_FINGERS = {
    "thumb": marked("thumb"),
    "index": marked("index finger"),
    "middle": marked("middle finger"),
    "ring": marked("ring finger"),
    "little": marked("little finger"),
}
_NAMES = {
    "thumb": marked("Thumb"),
    "index": marked("Index"),
    "middle": marked("Middle"),
    "ring": marked("Ring"),
    "little": marked("Little"),
    "whole": marked("Whole"),
    "wrist": marked("Wrist"),
}
_WORDS = {"flexion": marked("flexion"), "abduction": marked("abduction"), "tip": marked("tip")}
_HANDS = {"left": marked("left hand"), "right": marked("right hand")}
MODES = {
    "passive": marked("passive"),
    "assistive": marked("active-assisted"),
    "transparent": marked("active"),
    "resistive": marked("resisted"),
}
"""Therapy modes of files as clinicians call them."""
EXERCISES = {
    "open_close": "Hand opening and closing",
    "straight_fist": "Straight fist",
    "hook_fist": "Hook fist",
    "full_fist": "Full fist",
    "tabletop": "Tabletop",
    "index_pip": "Index PIP flexion",
    "dip_blocking": "DIP blocking",
    "finger_flexion": "Single-finger flexion and extension",
    "place_and_hold": "Place and hold",
    "spread": "Finger abduction (spread)",
    "thumb_abduction": "Thumb abduction",
    "thumb_extension": "Thumb extension",
    "opposition": "Thumb opposition to each finger",
    "pinch": "Tip pinch",
    "three_jaw_pinch": "Three-jaw pinch",
    "key_pinch": "Key pinch",
    "cylinder_grasp": "Cylinder grasp and release",
    "tapping": "Finger tapping",
    "wave": "Wave",
    "still": "Hold still",
    "range of motion sweep": "Today's range, measured",
    "fit check": "Fit check",
    "tone at three speeds": "Tone at three speeds",
}
"""Exercises of files in the words of the pages, whose catalogue translates them."""


def unit_shown(name: str, unit: str) -> str:
    """The unit that a person reads for a metric in this SI unit; empty where there is none."""
    return "%" if name in _PERCENT else _(_SHOWN[unit][1])


def number(name: str, unit: str, value: float) -> str:
    """A value without its unit, in the unit of ``unit_shown``."""
    if not math.isfinite(value):
        return MISSING
    if name in _COUNTS:
        return f"{value:.0f}"
    factor, _unit, digits = (100.0, "%", 0) if name in _PERCENT else _SHOWN[unit]
    text = f"{value * factor:.{digits}f}"
    return decimal(text[1:] if text.startswith("-") and not float(text) else text)


def with_unit(item: Metric | None) -> str:
    """A value with its unit, or a dash."""
    if item is None or not item.measurable:
        return MISSING
    unit = unit_shown(item.name, item.unit)
    between = "" if unit in ("°", "") else "\N{NO-BREAK SPACE}"
    return f"{number(item.name, item.unit, item.value)}{between}{unit}"


def span(low: str, high: str) -> str:
    """Two numbers that are already written, such as "1.0 to 2.5"; one where they are written alike."""
    return low if low == high else _("%(low)s to %(high)s", low=low, high=high)


def interval(item: Metric) -> str:
    """The 95 % interval without its unit; empty where there is none, or both ends read as the value does."""
    if item.interval is None:
        return ""
    low, high = (number(item.name, item.unit, end) for end in item.interval)
    return "" if low == high == number(item.name, item.unit, item.value) else span(low, high)


def joint_name(joint: str) -> str:
    """A joint as a clinician writes it: "Index PIP", "Thumb CMC abduction"."""
    digit, _part, part = joint.partition("_")
    words = [
        word.upper() if word in _SHORT else _(_WORDS.get(word, word)) for word in part.split("_") if word
    ]
    return " ".join([_(_NAMES[digit]) if digit in _NAMES else digit.capitalize(), *words])


def joint_words(joint: str) -> str:
    """A joint as a patient reads it: "index finger, middle joint (PIP)"."""
    digit, _part, part = joint.partition("_")
    return f"{_(_FINGERS.get(digit, digit))}, {_(_PARTS.get(part, part))}"


def subject_name(subject: str) -> str:
    """Any subject of a metric for a heading or row."""
    return joint_name(subject)


def hand(side: str) -> str:
    """Such as "right hand"."""
    return _(_HANDS.get(side, side))


def mode_words(modes: Iterable[str]) -> str:
    """Therapy modes, such as "passive and active-assisted"."""
    return _(" and ").join(_(MODES.get(mode, mode)) for mode in modes) or _("unknown")


def exercise_words(exercise: str) -> str:
    """The name of an exercise or movement; one that only its file knows without its underscores."""
    return _(EXERCISES.get(exercise, exercise.replace("_", " "))) if exercise else _("not named")


def capital(text: str) -> str:
    """A text that begins with a capital letter."""
    return f"{text[:1].upper()}{text[1:]}"
