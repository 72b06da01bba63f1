"""The formats of a report: the one table that the service, the command line and the pages read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sessions.reports.exchange import render_json
from sessions.reports.fhir import render_fhir
from sessions.reports.long_rows import render_csv, render_parquet
from sessions.reports.note import render_note
from sessions.reports.page import render_html
from sessions.reports.pdf import render_pdf
from sessions.reports.report import Report


@dataclass(frozen=True, slots=True)
class Format:
    """One format.

    Attributes:
        suffix: How the file's name ends, with the dot.
        media_type: What a browser is told.
        render: Makes the bytes.
    """

    suffix: str
    media_type: str
    render: Callable[[Report], bytes]


FORMATS: Mapping[str, Format] = {
    "html": Format(".html", "text/html", lambda report: render_html(report).encode()),
    "pdf": Format(".pdf", "application/pdf", render_pdf),
    "csv": Format(".csv", "text/csv", render_csv),
    "parquet": Format(".parquet", "application/vnd.apache.parquet", render_parquet),
    "fhir": Format(".fhir.json", "application/fhir+json", render_fhir),
    "json": Format(".json", "application/json", render_json),
    "note": Format(".txt", "text/plain; charset=utf-8", lambda report: render_note(report).encode()),
}
"""By the name that ``--format`` takes."""
