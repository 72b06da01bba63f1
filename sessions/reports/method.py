"""The last pages of a report: what each number means, its version, its limits, and where it comes from."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from sessions.metrics import Lineage, Metric, Summary, definition
from sessions.records import SessionHeader
from sessions.reports.paper import Block, Bullets, Heading, Hint, Pairs, Words

_LIMITS = (
    "Intervals of errors take the measurement error of all samples as fully correlated; those of a range "
    "take its two ends as independent. They hold what the sensors state, not what they do not know (strap "
    "slip, skin movement).",
    "Angles measured by {sources}. A camera cannot see markers under an exoskeleton.",
    "Smoothness is measured in the palm frame, stroke by stroke. Its reliability is known for arm movements "
    "only; the floor is what a perfectly smooth movement would score with this noise and frame rate.",
)
_LIMITS_OF_THERAPY = (
    "The robot's share comes from the interaction torque: recoil of stiff tissue and spasm look like effort.",
    "A passive robot makes anyone look good: compare errors only at equal stiffness.",
)


_OF_DEVICE = ("device_min_rad", "device_max_rad")
"""Keys of the header's limits that are the device's own and not the patient's."""


def method_blocks(summary: Summary) -> tuple[Block, ...]:
    """Everything that somebody needs who doubts a number."""
    limits = [text.format(sources=sources(summary)) for text in _LIMITS]
    limits += _LIMITS_OF_THERAPY if summary.header.kind == "therapy" else ()
    ordered = _content(summary.header.prescription) + _content(summary.header.limits)
    blocks: list[Block] = [
        Heading("How it was measured"),
        definitions(item.name for item in summary.metrics),
        Heading("Limits of these numbers", 3),
        Bullets(tuple(limits)),
    ]
    if ordered:
        blocks += [Heading("Prescription and limits that held", 3), Pairs(ordered)]
    return (
        *blocks,
        Heading("Where the numbers come from", 3),
        Hint(_file(summary)),
        _lineages(summary.metrics, summary.header),
    )


def definitions(names: Iterable[str]) -> Words:
    """What each of these metrics means, and the version of its method."""
    known = [definition(name) for name in dict.fromkeys(names)]
    rows = tuple((item.title, item.meaning, f"{item.name}, version {item.version}") for item in known)
    return Words(("Number", "What it means", "Method"), rows)


def sources(summary: Summary) -> str:
    """What measured the file, such as "encoder"."""
    named = dict.fromkeys(item.lineage.source for item in summary.metrics if item.lineage.source)
    return ", ".join(named) or "not recorded"


def _file(summary: Summary) -> str:
    header = summary.header
    parts = [f"File SHA-256 {summary.sha256}, written by version {header.software_version}"]
    if header.marker_protocol:
        parts.append(f"marker protocol {header.marker_protocol}")
    if header.calibration_digest:
        parts.append(f"calibration {header.calibration_digest}")
    return ", ".join([*parts, *(f"made from {parent}" for parent in header.parents)])


def _lineages(metrics: tuple[Metric, ...], header: SessionHeader) -> Words:
    """Each different lineage once, with the names of the metrics that share it."""
    grouped: dict[Lineage, list[str]] = {}
    for item in metrics:
        names = grouped.setdefault(item.lineage, [])
        if item.name not in names:
            names.append(item.name)
    rows = tuple(
        (
            ", ".join(names),
            ", ".join(lineage.topics),
            _span(lineage, header.monotonic_start_ns),
            lineage.source,
            lineage.conditions or "—",
        )
        for lineage, names in grouped.items()
    )
    return Words(("Numbers", "Topics", "Time span (s)", "Source", "Conditions"), rows)


def _span(lineage: Lineage, start_ns: int) -> str:
    if not lineage.t_end_ns:
        return "—"
    return f"{(lineage.t_start_ns - start_ns) / 1e9:.2f} to {(lineage.t_end_ns - start_ns) / 1e9:.2f}"


def _content(text: str) -> tuple[tuple[str, str], ...]:
    """Names and values of a JSON object of the header; empty where it holds none."""
    try:
        content: Any = json.loads(text)
    except ValueError:
        return ()
    if not isinstance(content, dict):
        return ()
    return tuple(
        (str(name).replace("_", " "), _plain(value))
        for name, value in content.items()
        if name not in _OF_DEVICE
    )


def _plain(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list):
        return ", ".join(_plain(item) for item in value)
    return str(value)
