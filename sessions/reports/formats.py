"""The formats of a report: the one table that the service, the command line and the pages read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sessions.reports.exchange import render_json
from sessions.reports.fhir import render_fhir
from sessions.reports.language import SOURCE, speaking
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
        worded: Whether people read it: then it is in the reader's language, else always in English.
    """

    suffix: str
    media_type: str
    render: Callable[[Report], bytes]
    worded: bool = False

    def made(self, report: Report, language: str = SOURCE) -> bytes:
        """The report in this format.

        Args:
            report: What is printed.
            language: Code of a language of ``LANGUAGES``; formats for programs take no notice.

        Raises:
            Refused: There is no such language.
        """
        with speaking(language if self.worded else SOURCE):
            return self.render(report)


FORMATS: Mapping[str, Format] = {
    "html": Format(".html", "text/html", lambda report: render_html(report).encode(), worded=True),
    "pdf": Format(".pdf", "application/pdf", render_pdf, worded=True),
    "csv": Format(".csv", "text/csv", render_csv),
    "parquet": Format(".parquet", "application/vnd.apache.parquet", render_parquet),
    "fhir": Format(".fhir.json", "application/fhir+json", render_fhir),
    "json": Format(".json", "application/json", render_json),
    "note": Format(
        ".txt", "text/plain; charset=utf-8", lambda report: render_note(report).encode(), worded=True
    ),
}
"""By the name that ``--format`` takes."""
