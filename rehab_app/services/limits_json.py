"""Limits as the catalogue keeps them: one JSON object, SI; a wrist angle of any is null."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from rehab_app.errors import Refused, RobotRefused
from robot_iface.types import Hull, Limits

_ARRAYS = (
    "q_min_rad",
    "q_max_rad",
    "flexion_speed_rad_s",
    "extension_speed_rad_s",
    "tau_interaction_nm",
    "tau_nm",
)
_NUMBERS = ("tau_rate_nm_s", "power_w", "trip_speed_rad_s", "margin_rad")
_TIMES = ("measured_utc_ns", "expires_utc_ns")


def limits_to_json(limits: Limits) -> str:
    """Limits as JSON text."""
    table: dict[str, Any] = {name: getattr(limits, name).tolist() for name in _ARRAYS}
    table |= {name: getattr(limits, name) for name in (*_NUMBERS, *_TIMES)}
    table["hulls"] = [
        {"joints": list(hull.joints), "corners_rad": hull.corners_rad.tolist()} for hull in limits.hulls
    ]
    table["wrist_rad"] = None if math.isnan(limits.wrist_rad) else limits.wrist_rad
    return json.dumps(table, sort_keys=True)


def limits_from_json(text: str) -> Limits:
    """The limits in a text of ``limits_to_json``.

    Raises:
        Refused: The text does not hold limits.
    """
    try:
        table: dict[str, Any] = json.loads(text)
        parts: dict[str, Any] = {name: np.array(table[name], dtype=np.float64) for name in _ARRAYS}
        parts |= {name: float(table[name]) for name in _NUMBERS}
        parts |= {name: int(table[name]) for name in _TIMES}
        hulls = tuple(
            Hull((str(one["joints"][0]), str(one["joints"][1])), np.array(one["corners_rad"], np.float64))
            for one in table["hulls"]
        )
        wrist = table["wrist_rad"]
        limits = Limits(**parts, hulls=hulls, wrist_rad=math.nan if wrist is None else float(wrist))
    except (KeyError, IndexError, TypeError, ValueError, RobotRefused) as error:
        raise _damaged() from error
    arrays = [parts[name] for name in _ARRAYS]
    if len({array.shape for array in arrays}) != 1 or not bool(np.isfinite(arrays).all()):
        raise _damaged()
    return limits


def _damaged() -> Refused:
    return Refused("stored limits", "not readable", "limits as they were stored", "measure the limits again")
