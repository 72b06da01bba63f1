"""Numbers and names as a person reads them: degrees, millimetres, words. Files stay in SI units."""

from __future__ import annotations

import math

from sessions.metrics import Metric

_SHOWN = {
    "rad": (180.0 / math.pi, "°", 1),
    "m": (1000.0, "mm", 1),
    "m/s": (1000.0, "mm/s", 0),
    "s": (1.0, "s", 2),
    "Hz": (60.0, "per min", 1),
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
    "mcp_flexion": "knuckle (MCP)",
    "mcp_abduction": "knuckle, sideways (MCP abduction)",
    "pip": "middle joint (PIP)",
    "dip": "end joint (DIP)",
    "cmc_flexion": "base (CMC flexion)",
    "cmc_abduction": "base, sideways (CMC abduction)",
    "ip": "end joint (IP)",
}


def unit_shown(name: str, unit: str) -> str:
    """The unit that a person reads for a metric in this SI unit; empty where there is none."""
    return "%" if name in _PERCENT else _SHOWN[unit][1]


def number(name: str, unit: str, value: float) -> str:
    """A value without its unit, in the unit of ``unit_shown``."""
    if not math.isfinite(value):
        return MISSING
    if name in _COUNTS:
        return f"{value:.0f}"
    factor, _, digits = (100.0, "%", 0) if name in _PERCENT else _SHOWN[unit]
    text = f"{value * factor:.{digits}f}"
    return text[1:] if text.startswith("-") and not float(text) else text


def with_unit(item: Metric | None) -> str:
    """A value with its unit, or a dash."""
    if item is None or not item.measurable:
        return MISSING
    unit = unit_shown(item.name, item.unit)
    between = "" if unit in ("°", "") else "\N{NO-BREAK SPACE}"
    return f"{number(item.name, item.unit, item.value)}{between}{unit}"


def interval(item: Metric) -> str:
    """The 95 % interval without its unit, empty where there is none."""
    if item.interval is None:
        return ""
    low, high = item.interval
    return f"{number(item.name, item.unit, low)} to {number(item.name, item.unit, high)}"


def joint_name(joint: str) -> str:
    """A joint as a clinician writes it: "Index PIP", "Thumb CMC abduction"."""
    digit, _, part = joint.partition("_")
    words = [word.upper() if word in _SHORT else word for word in part.split("_")]
    return " ".join([digit.capitalize(), *words])


def joint_words(joint: str) -> str:
    """A joint as a patient reads it: "index finger, middle joint (PIP)"."""
    digit, _, part = joint.partition("_")
    finger = "thumb" if digit == "thumb" else f"{digit} finger"
    return f"{finger}, {_PARTS.get(part, part)}"


def subject_name(subject: str) -> str:
    """Any subject of a metric for a heading or row."""
    return joint_name(subject) if "_" in subject else subject.capitalize()


def plural(count: int, word: str) -> str:
    """Such as "1 repetition" and "2 repetitions"."""
    return f"{count} {word}" if count == 1 else f"{count} {word}s"
