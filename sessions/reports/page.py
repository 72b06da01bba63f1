"""Renders a report as one HTML file that needs nothing else and prints on A4."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import resources
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from sessions.metrics import Definition, Lineage, Summary, definition
from sessions.reports.figures import joints_picture, paths_picture, repetitions_picture
from sessions.reports.report import Report
from sessions.reports.sentences import sentences
from sessions.reports.tables import (
    Notes,
    Table,
    digit_table,
    error_table,
    joint_tables,
    marker_table,
    overall_table,
    repetition_table,
)

TEMPLATES = resources.files("web_assets") / "reports"


@dataclass(frozen=True, slots=True)
class Section:
    """One file of the report, ready for the template."""

    summary: Summary
    title: str
    facts: tuple[tuple[str, str], ...]
    sentences: tuple[str, str, str]
    paths: Markup
    joints: Markup
    by_repetition: Markup
    overall: Table
    joint_table: Table
    digit_table: Table
    error_table: Table
    repetition_table: Table
    other_joints: Table
    marker_table: Table
    notes: tuple[str, ...]
    definitions: tuple[Definition, ...]
    lineages: tuple[tuple[str, Lineage], ...]
    prescription: tuple[tuple[str, str], ...]
    limits: tuple[tuple[str, str], ...]


def render_html(report: Report) -> str:
    """One self-contained page; the same report gives the same bytes."""
    environment = Environment(
        loader=FunctionLoader(_template),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    sections = [_section(summary, f"s{number}") for number, summary in enumerate(report.summaries)]
    page = environment.get_template("report.html.j2")
    return page.render(report=report, sections=sections) + "\n"


def _template(name: str) -> str:
    return (TEMPLATES / name).read_text(encoding="utf-8")


def _section(summary: Summary, key: str) -> Section:
    notes = Notes()
    overall = overall_table(summary, notes)
    joints, others = joint_tables(summary, notes)
    digits, errors = digit_table(summary, notes), error_table(summary, notes)
    markers = marker_table(summary, notes)
    return Section(
        summary,
        "Recorded movement" if summary.header.kind == "take" else "Therapy session",
        _facts(summary),
        sentences(summary),
        # Markup: these three are drawn here, and every word in them was escaped when drawn.
        Markup(paths_picture(summary.overlay, f"{key}p")),
        Markup(joints_picture(summary, f"{key}j")),
        Markup(repetitions_picture(summary, f"{key}r")),
        overall,
        joints,
        digits,
        errors,
        repetition_table(summary),
        others,
        markers,
        tuple(notes.texts),
        tuple(definition(name) for name in dict.fromkeys(item.name for item in summary.metrics)),
        _lineages(summary),
        _content(summary.header.prescription),
        _content(summary.header.limits),
    )


def _facts(summary: Summary) -> tuple[tuple[str, str], ...]:
    header = summary.header
    started = datetime.fromtimestamp(header.utc_start_ns // 1_000_000_000, tz=UTC)
    whose = "Recorded hand" if header.kind == "take" else "Patient"
    facts = [
        (whose, f"{header.subject_id or 'not named'}, {header.side} hand"),
        ("Exercise", header.exercise or "not named"),
        ("Recorded", f"{started:%d %B %Y, %H:%M} UTC, {summary.duration_s:.1f} s"),
        ("Measured by", _sources(summary)),
    ]
    if header.kind == "therapy":
        facts.append(("Mode", ", ".join(summary.modes) or "not recorded"))
        facts.append(("Stiffness used", summary.conditions or "not recorded"))
        stops = "; ".join(f"{stop.text or stop.cause} ({stop.t_s:.1f} s)" for stop in summary.stops)
        facts.append(("Stops", stops or "none"))
    return tuple(facts)


def _sources(summary: Summary) -> str:
    named = dict.fromkeys(item.lineage.source for item in summary.metrics if item.lineage.source)
    return ", ".join(named) or "not recorded"


def _lineages(summary: Summary) -> tuple[tuple[str, Lineage], ...]:
    """Each different lineage once, with the names of the metrics that share it."""
    grouped: dict[Lineage, list[str]] = {}
    for item in summary.metrics:
        names = grouped.setdefault(item.lineage, [])
        if item.name not in names:
            names.append(item.name)
    return tuple((", ".join(names), lineage) for lineage, names in grouped.items())


def _content(text: str) -> tuple[tuple[str, str], ...]:
    """Names and values of a JSON object of the header; empty where it holds none."""
    try:
        content: Any = json.loads(text)
    except ValueError:
        return ()
    if not isinstance(content, dict):
        return ()
    return tuple((str(name).replace("_", " "), _plain(value)) for name, value in content.items())


def _plain(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list):
        return ", ".join(_plain(item) for item in value)
    return str(value)
