"""Intervals brought to what was measured: the virtual camera knows the truth, so its can be checked.

The hand fit states the error of one frame with everything it does not know of the hand; an angle that is
held, filtered and compared within one take is surer than that. Over 88 takes (four movements, seeds 1 to 12
and 101 to 110) the error of each number was compared with the half-width that follows from the stated
covariance; 95 % of the errors lay within the share below. The errors of aperture, span and finger to palm
hang on the hand that was fitted, so these were set anew from a hand each (seeds 241 and after, below 301):
halfway between 1.96 root mean squares and the 95th percentile. The stated covariance counts what two tips or
tip and palm have in common as if it were independent, which is why these shares are small. A share is taken
only where it was measured: for the virtual camera. Other cameras keep the whole stated width: skin, straps
and real light are not in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sessions.metrics.metric import Metric

SOURCE = "virtual-camera"
SHARES: Mapping[str, float] = {
    "range_of_motion": 0.225,
    "angle_min": 0.288,
    "angle_max": 0.30,
    "range_share": 0.37,
    "total_active_motion": 0.20,
    "active_motion_share": 0.20,
    "aperture": 0.048,
    "span": 0.035,
    "finger_spread": 0.124,
    "finger_to_palm": 0.125,
}
"""Part of the stated half-width within which 95 % of the errors against the truth lay."""
WORDS = "interval scaled to the errors measured against the virtual camera's truth"
_SIGNED = frozenset(("angle_min", "angle_max", "total_active_motion", "active_motion_share"))


def honest(metrics: Sequence[Metric]) -> list[Metric]:
    """The same numbers; intervals of the virtual camera's at their measured width.

    Args:
        metrics: Numbers of one take.
    """
    return [_scaled(item) for item in metrics]


def _scaled(item: Metric) -> Metric:
    share = SHARES.get(item.name)
    if share is None or item.interval is None or item.lineage.source != SOURCE:
        return item
    low, high = item.interval
    half = share * max(item.value - low, high - item.value)
    bottom = item.value - half if item.name in _SIGNED else max(0.0, item.value - half)
    conditions = "; ".join(text for text in (item.lineage.conditions, WORDS) if text)
    return replace(
        item, interval=(bottom, item.value + half), lineage=replace(item.lineage, conditions=conditions)
    )
