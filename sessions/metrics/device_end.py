"""The device's end of range is never the patient's (hazard 15): such an angle is told as "at least"."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sessions.metrics.metric import Metric

NEAR_RAD = math.radians(1.0)
DEVICE, TODAY = "device limit", "today's limit"


@dataclass(frozen=True, slots=True)
class Ends:
    """Where one joint was stopped, rad; NaN where unknown.

    Attributes:
        device: Smallest and largest angle of the device.
        today: Smallest and largest angle that was allowed on that day.
    """

    device: tuple[float, float]
    today: tuple[float, float]

    def met(self, angle_rad: float, *, high: bool) -> str:
        """Which end an angle lies at or beyond, empty if none."""
        for words, ends in ((DEVICE, self.device), (TODAY, self.today)):
            left = ends[1] - angle_rad if high else angle_rad - ends[0]
            if left <= NEAR_RAD:
                return words
        return ""


def ends_of(limits: str, joints: Sequence[str]) -> Mapping[str, Ends]:
    """The ends that a header's ``limits`` state, by joint; joints of which nothing is known are left out.

    Args:
        limits: JSON with ``device_min_rad``, ``device_max_rad``, ``q_min_rad``, ``q_max_rad``, each (J,)
            or absent.
        joints: The J robot joints of the header.
    """
    try:
        table: Any = json.loads(limits)
    except ValueError:
        return {}
    if not isinstance(table, dict):
        return {}
    device, today = (
        list(zip(_column(table, low, joints), _column(table, high, joints), strict=True))
        for low, high in (("device_min_rad", "device_max_rad"), ("q_min_rad", "q_max_rad"))
    )
    return {joint: Ends(*pair) for joint, *pair in zip(joints, device, today, strict=True)}


def at_device_end(metrics: Sequence[Metric], ends: Mapping[str, Ends]) -> list[Metric]:
    """Mark ranges that ended where the device or today's limit did.

    Args:
        metrics: ``range_of_motion``, ``angle_min`` and ``angle_max`` of joints, in any order.
        ends: What is known of the joints.
    """
    values = {(item.name, item.subject): item.value for item in metrics}
    found: list[Metric] = []
    for item in metrics:
        known = ends.get(item.subject)
        if known is None or not item.measurable:
            found.append(item)
            continue
        low = known.met(values.get(("angle_min", item.subject), math.nan), high=False)
        high = known.met(values.get(("angle_max", item.subject), math.nan), high=True)
        met = {"angle_min": low, "angle_max": high}.get(item.name, high or low)
        found.append(_one_sided(item, met) if met else item)
    return found


def _one_sided(item: Metric, met: str) -> Metric:
    """Only the end of the interval that is the hand's own remains, in words."""
    words = f"at most, {met}" if item.name == "angle_min" else f"at least, {met}"
    if item.interval is not None:
        end = item.interval[1] if item.name == "angle_min" else item.interval[0]
        bound = "above" if item.name == "angle_min" else "below"
        words += f"; one-sided interval, not {bound} {math.degrees(end):.1f} deg"
    said = item.status.removeprefix("flagged: ")
    return replace(item, interval=None, status=f"flagged: {words}" + ("" if said == "ok" else f"; {said}"))


def _column(table: dict[str, Any], name: str, joints: Sequence[str]) -> list[float]:
    column: Any = table.get(name)
    if not isinstance(column, list) or len(column) != len(joints):
        return [math.nan] * len(joints)
    return [float(value) if isinstance(value, int | float) else math.nan for value in column]
