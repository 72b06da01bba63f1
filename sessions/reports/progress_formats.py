"""Progress and comparisons in every format in which they exist."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from sessions.errors import Refused
from sessions.reports.language import SOURCE, _, speaking
from sessions.reports.page import html_of
from sessions.reports.past import Past
from sessions.reports.pdf import pdf_of
from sessions.reports.progress import Line, Progress, leading_line, line
from sessions.reports.progress_paper import progress_paper
from sessions.reports.progress_sentences import progress_sentences
from sessions.reports.progress_tables import ALL_NAMES
from sessions.reports.wording import hand, joint_name

PROGRESS_FORMATS: Mapping[str, tuple[str, str]] = {
    "html": (".html", "text/html"),
    "pdf": (".pdf", "application/pdf"),
    "csv": (".csv", "text/csv"),
    "json": (".json", "application/json"),
    "note": (".txt", "text/plain; charset=utf-8"),
}
"""Suffix and media type by name."""
_WORDED = frozenset(("html", "pdf", "note"))
_COLUMNS = (
    "session_id file_sha256 utc_start_ns side mode name subject value low high status version source"
).split()


def render_progress(progress: Progress, format_name: str, language: str = SOURCE) -> bytes:
    """Progress in one format; a format for programs is always in English.

    Raises:
        Refused: There is no such format or language.
    """
    with speaking(language if format_name in _WORDED else SOURCE):
        return _rendered(progress, format_name)


def _rendered(progress: Progress, format_name: str) -> bytes:
    if format_name == "html":
        return html_of(progress_paper(progress)).encode()
    if format_name == "pdf":
        return pdf_of(progress_paper(progress))
    if format_name == "csv":
        return _csv(progress)
    if format_name == "json":
        return json.dumps(progress_object(progress), ensure_ascii=False, allow_nan=False, indent=1).encode()
    if format_name == "note":
        return _note(progress).encode()
    bound = "one of " + ", ".join(PROGRESS_FORMATS)
    raise Refused("progress format", repr(format_name), bound, "choose one of them")


def progress_object(progress: Progress) -> dict[str, Any]:
    """Progress as plain values, SI units; a number that cannot be had is None."""
    return {
        "patient": progress.subject_id,
        "side": progress.side,
        "sentences": list(progress_sentences(progress, leading_line(progress))),
        "sessions": [_session(past) for past in progress.pasts],
        "left_out": [
            {"session_id": item.session_id, "utc_start_ns": item.utc_start_ns, "reason": item.reason}
            for item in progress.left_out
        ],
        "changes": [_change(item) for item in lines_of(progress)],
        "norms": [asdict(one) for one in progress.norms],
        "software_version": progress.software_version,
    }


def lines_of(progress: Progress) -> tuple[Line, ...]:
    """Every number that may be compared, metric after metric."""
    named = dict.fromkeys(
        (item.name, item.subject)
        for past in progress.pasts
        for item in past.numbers
        if item.name in ALL_NAMES and item.value is not None
    )
    found = (line(progress, name, subject) for name, subject in sorted(named, key=_order))
    return tuple(item for item in found if item is not None)


def _order(named: tuple[str, str]) -> tuple[int, str]:
    return ALL_NAMES.index(named[0]), named[1]


def _session(past: Past) -> dict[str, Any]:
    return {
        "session_id": past.session_id,
        "file_sha256": past.sha256,
        "utc_start_ns": past.utc_start_ns,
        "exercise": past.exercise,
        "modes": list(past.modes),
        "stiffness": past.conditions or None,
        "stops": list(past.stops),
    }


def _change(item: Line) -> dict[str, Any]:
    return {
        "name": item.name,
        "subject": item.subject,
        "unit": item.unit,
        "baseline": None if item.baseline is None else item.baseline.value,
        "last": None if item.last is None else item.last.value,
        "now": item.now.value,
        "difference": _finite(item.change.difference),
        "minimal_detectable_change": _finite(item.change.bound),
        "verdict": item.change.verdict,
        "why": item.change.why,
        "source": item.now.source,
        "stiffness": item.session.conditions or None,
        "not_compared": item.others[0],
    }


def _csv(progress: Progress) -> bytes:
    """Long format: one row per session and number."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(_COLUMNS)
    for past in progress.pasts:
        for item in past.numbers:
            cells = ("" if end is None else repr(end) for end in (item.value, item.low, item.high))
            writer.writerow(
                (past.session_id, past.sha256, past.utc_start_ns, past.side, " ".join(past.modes), item.name,
                 item.subject, *cells, item.status, item.version, item.source)
            )  # fmt: skip
    return text.getvalue().encode()


def _note(progress: Progress) -> str:
    told = progress_sentences(progress, leading_line(progress))
    real = [
        item
        for item in lines_of(progress)
        if item.change.verdict == "real" and item.name == "range_of_motion"
    ]
    changed = ", ".join(
        f"{joint_name(item.subject)} {math.degrees(item.change.difference):+.0f}°" for item in real
    )
    lines = [
        f"{_(progress.title)}: {progress.subject_id}, {hand(progress.side)}.",
        *told,
        _("Real changes of range: %(changes)s.", changes=changed or _("none")),
        _("Not a certified medical device."),
    ]
    return "\n".join(lines) + "\n"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
