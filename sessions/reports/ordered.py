"""What was prescribed and the limits that held, as a clinician reads them: by joint, in degrees."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from sessions.records import SessionHeader
from sessions.reports.language import _, decimal, marked, short_day
from sessions.reports.paper import Block, Heading, Hint, Numbers, Pairs
from sessions.reports.tables import Cell, Row, Table
from sessions.reports.wording import MISSING, MODES, joint_name

_DEGREES = 180.0 / math.pi
_BY_JOINT = (
    ("q_min_rad", marked("Least angle (°)"), _DEGREES, 0),
    ("q_max_rad", marked("Largest angle (°)"), _DEGREES, 0),
    ("flexion_speed_rad_s", marked("Speed into flexion (°/s)"), _DEGREES, 0),
    ("extension_speed_rad_s", marked("Speed into extension (°/s)"), _DEGREES, 0),
    ("tau_interaction_nm", marked("Torque on the hand (Nm)"), 1.0, 2),
    ("tau_nm", marked("Motor torque (Nm)"), 1.0, 2),
)
_FOR_ALL = (
    ("tau_rate_nm_s", marked("Change of torque"), 1.0, 0, "Nm/s"),
    ("power_w", marked("Power of a joint"), 1.0, 1, "W"),
    ("trip_speed_rad_s", marked("Speed that stops"), _DEGREES, 0, "°/s"),
    ("margin_rad", marked("Margin beyond the range"), _DEGREES, 0, "°"),
    ("wrist_rad", marked("Wrist extension"), _DEGREES, 0, "°"),
)
_ORDER = (
    ("mode", marked("Mode"), 0.0, ""),
    ("speed", marked("Speed"), 100.0, "%"),
    ("repetitions", marked("Repetitions"), 1.0, ""),
    ("minutes", marked("Time at most"), 1.0, "min"),
    ("stiffness_multiple", marked("Stiffness"), 1.0, marked("times the thesis gains")),
    ("assist_forgetting", marked("Forgetting of support"), 1.0, ""),
    ("resistance", marked("Resistance"), 100.0, marked("% of the torque limit")),
    ("ramp_s", marked("Rise of stiffness"), 1.0, "s"),
    ("hold_s", marked("Hold"), 1.0, "s"),
    ("rest_s", marked("Rest"), 1.0, "s"),
    ("cue_timeout_s", marked("Wait for the patient"), 1.0, "s"),
    ("space", marked("Impedance at"), 0.0, ""),
    ("warm_up_repetitions", marked("Warm-up repetitions"), 1.0, ""),
    ("skin_check_s", marked("Skin check after"), 1.0, "s"),
)
_WORDS = {"joint": marked("the joints"), "fingertip": marked("the fingertips"), **MODES}
_ONLY_IN = {"assist_forgetting": "assistive", "cue_timeout_s": "assistive", "resistance": "resistive"}
"""What says something in one mode only."""
_ZERO_IS_NONE = frozenset(("minutes", "warm_up_repetitions", "skin_check_s"))


def ordered_blocks(header: SessionHeader) -> list[Block]:
    """Prescription and limits; nothing where the header holds none."""
    ordered, limits = _object(header.prescription), _object(header.limits)
    blocks: list[Block] = []
    if ordered:
        blocks += [Heading(_("Prescription"), 3), Pairs(_prescription(ordered))]
    if limits:
        blocks += [Heading(_("Limits that held"), 3), Hint(_measured(limits)), *_limits(header, limits)]
    return blocks


def _prescription(ordered: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    mode = ordered.get("mode")
    rows = [
        (_(name), _quantity(ordered[key], factor, unit))
        for key, name, factor, unit in _ORDER
        if key in ordered
        and _ONLY_IN.get(key, mode) == mode
        and not (key in _ZERO_IS_NONE and not ordered[key])
    ]
    known = {key for key, *_rest in _ORDER} | {"assistance"}
    rows += [(_name(key), _plain(value)) for key, value in ordered.items() if key not in known]
    return tuple(rows)


def _quantity(value: Any, factor: float, unit: str) -> str:
    if isinstance(value, str):
        return _(_WORDS.get(value, value))
    if not isinstance(value, int | float):
        return _plain(value)
    between = "" if unit == "°" or not unit else " "
    return f"{decimal(f'{factor * value:.4g}')}{between}{_(unit)}"


def _limits(header: SessionHeader, limits: Mapping[str, Any]) -> list[Block]:
    """A row per driven joint where the columns fit; what holds for all joints below."""
    joints = header.robot_joints
    there = [one for one in _BY_JOINT if _numbers(limits.get(one[0]), len(joints))]
    rows = tuple(
        Row(
            joint_name(joint),
            tuple(
                Cell(decimal(f"{limits[key][place] * factor:.{digits}f}"))
                for key, _n, factor, digits in there
            ),
        )
        for place, joint in enumerate(joints)
    )
    columns = ("", *(_(name) for _key, name, _factor, _digits in there))
    pairs = tuple(
        (_(name), f"{decimal(f'{limits[key] * factor:.{digits}f}')}{'' if unit == '°' else ' '}{unit}")
        for key, name, factor, digits, unit in _FOR_ALL
        if isinstance(limits.get(key), int | float)
    )
    known = {one[0] for one in (*_BY_JOINT, *_FOR_ALL)} | _NOT_SHOWN
    others = tuple((_name(key), _plain(value)) for key, value in limits.items() if key not in known)
    table = Numbers(Table(_("By joint"), columns, rows if there else ()), "small")
    return [table, Pairs((*pairs, *others))]


_NOT_SHOWN = {"device_min_rad", "device_max_rad", "hulls", "measured_utc_ns", "expires_utc_ns"}
"""What is the device's own, or stands in the sentence above."""


def _measured(limits: Mapping[str, Any]) -> str:
    """Where the limits come from."""
    when = limits.get("measured_utc_ns")
    if not isinstance(when, int) or not when:
        return _("Defaults as shipped: nobody measured this hand's limits that day.")
    said = _("Measured on this hand on %(day)s.", day=short_day(when))
    hulls = limits.get("hulls")
    pairs = len(hulls) if isinstance(hulls, list) else 0
    if not pairs:
        return said
    narrower = _("Joint pairs with a narrower common range: %(n)s.", n=pairs)
    return f"{said} {narrower}"


def _numbers(value: Any, count: int) -> bool:
    return (
        isinstance(value, list)
        and len(value) == count
        and all(isinstance(one, int | float) and math.isfinite(one) for one in value)
    )


def _object(text: str) -> dict[str, Any]:
    """A JSON object of the header; empty where it holds none."""
    try:
        content: Any = json.loads(text)
    except ValueError:
        return {}
    return content if isinstance(content, dict) else {}


def _name(key: Any) -> str:
    return str(key).replace("_", " ")


def _plain(value: Any) -> str:
    if isinstance(value, float):
        return decimal(f"{value:.4g}")
    if isinstance(value, list):
        return ", ".join(_plain(item) for item in value)
    return MISSING if value is None else str(value)
