"""Assessments and entered scores as the progress report reads them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rehab_app.services.outcome_series import Series
from rehab_app.services.protocol_records import KeptResult
from rehab_app.services.protocol_results import JointRange
from sessions.reports.assessed import Ends, Tone, ranges_as_pasts
from sessions.reports.past import Past
from sessions.reports.progress import Score


def assessed_ranges(results: Sequence[KeptResult], side: str) -> tuple[tuple[Past, ...], tuple[Past, ...]]:
    """Range assessments of one hand, oldest first: what the patient reached, what the device reached.

    Args:
        results: Results of a patient, newest first.
        side: Side of the hand.
    """
    pairs = [
        ranges_as_pasts(
            kept.result.session,
            kept.utc_ns,
            kept.result.side,
            kept.result.device,
            tuple(_ends(one) for one in kept.result.ranges),
        )
        for kept in reversed(results)
        if kept.result.protocol == "range" and kept.result.side == side
    ]
    return tuple(active for active, _ in pairs), tuple(passive for _, passive in pairs)


def assessed_tones(results: Sequence[KeptResult], side: str) -> tuple[Tone, ...]:
    """Tone assessments of one hand, oldest first; arguments as of ``assessed_ranges``."""
    return tuple(
        Tone(
            kept.utc_ns,
            kept.result.device,
            one.joint,
            tuple(_known(speed) for speed in one.reached_rad_s),
            tuple(_known(torque) for torque in one.resistance_nm),
            _known(one.per_speed_nms_rad),
            one.interval_nms_rad,
        )
        for kept in reversed(results)
        if kept.result.protocol == "tone" and kept.result.side == side
        for one in kept.result.tones
    )


def _ends(one: JointRange) -> Ends:
    return Ends(
        one.joint,
        (_known(one.active_min_rad), _known(one.active_max_rad)),
        (_known(one.passive_min_rad), _known(one.passive_max_rad)),
        one.min_at_device_end or one.max_at_device_end,
    )


def _known(value: float | None) -> float:
    return math.nan if value is None else value


def score_of(series: Series) -> Score:
    """A score that the clinic took itself, in words."""
    chosen = series.measure
    unit = f" ({chosen.shown})" if chosen.shown else ""
    name = ", ".join(part for part in (chosen.words, series.side, series.place) if part) + unit
    change = "—" if series.change is None else f"{round(series.change / chosen.per_shown, 2):+g}"
    return Score(
        name,
        chosen.text(series.baseline.value),
        "—" if series.last is None else chosen.text(series.last.value),
        chosen.text(series.now.value),
        change,
        _meaning(series),
    )


def _meaning(series: Series) -> str:
    """The change beside the published one that matters to patients."""
    if series.change is None:
        return "measured once"
    if series.measure.mcid is None:
        return f"{series.direction}; no important difference is published"
    low, high = (round(end / series.measure.per_shown, 2) for end in series.measure.mcid)
    published = series.measure.mcid_words or (f"{low:g}" if low == high else f"{low:g} to {high:g}")
    return f"{series.direction}, {series.meaning} (published: {published})"
