"""The numbers in long format, one row per metric, as CSV and as Parquet: the same columns in both."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from typing import Any

from sessions.errors import Refused
from sessions.metrics import Metric, Summary
from sessions.reports.report import Report

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings that a spreadsheet takes for a formula."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LongRow:
    """One metric of one file, SI units; a number that cannot be had is None, and ``status`` says why."""

    session_id: str
    file_sha256: str
    kind: str
    subject_id: str
    side: str
    exercise: str
    mode: str
    started_utc: str
    name: str
    subject: str
    value: float | None
    unit: str
    low: float | None
    high: float | None
    status: str
    version: str
    source: str
    conditions: str
    topics: str
    t_start_ns: int
    t_end_ns: int
    software_version: str


COLUMNS = tuple(field.name for field in fields(LongRow))


def long_rows(report: Report) -> tuple[LongRow, ...]:
    """One row per metric, file after file."""
    return tuple(
        _row(summary, item, report.software_version)
        for summary in report.summaries
        for item in summary.metrics
    )


def render_csv(report: Report) -> bytes:
    """UTF-8 CSV with a heading; a missing number is an empty field.

    A text that a spreadsheet would run as a formula begins with an apostrophe.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    for row in long_rows(report):
        writer.writerow([_field(getattr(row, name)) for name in COLUMNS])
    return text.getvalue().encode()


def render_parquet(report: Report) -> bytes:
    """Parquet, ZSTD; a missing number is null.

    Raises:
        Refused: The extra for Parquet is not installed.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError as error:
        raise Refused(
            "report format",
            "parquet without pyarrow",
            "the extra parquet",
            "install rehab-app[parquet], or choose csv",
        ) from error
    arrow: Any = pa
    files: Any = pq
    kinds = {"value": arrow.float64(), "low": arrow.float64(), "high": arrow.float64()}
    kinds |= {"t_start_ns": arrow.int64(), "t_end_ns": arrow.int64()}
    schema = arrow.schema([(name, kinds.get(name, arrow.string())) for name in COLUMNS])
    rows = [{name: getattr(row, name) for name in COLUMNS} for row in long_rows(report)]
    sink = io.BytesIO()
    files.write_table(arrow.Table.from_pylist(rows, schema=schema), sink, compression="zstd")
    return sink.getvalue()


def _row(summary: Summary, item: Metric, software_version: str) -> LongRow:
    header, lineage = summary.header, item.lineage
    low, high = item.interval or (None, None)
    started = datetime.fromtimestamp(header.utc_start_ns / 1e9, tz=UTC)
    return LongRow(
        session_id=header.session_id,
        file_sha256=summary.sha256,
        kind=header.kind,
        subject_id=header.subject_id,
        side=header.side,
        exercise=header.exercise,
        mode=" ".join(summary.modes),
        started_utc=started.isoformat(timespec="milliseconds"),
        name=item.name,
        subject=item.subject,
        value=item.value if math.isfinite(item.value) else None,
        unit=item.unit,
        low=low,
        high=high,
        status=item.status,
        version=item.version,
        source=lineage.source,
        conditions=lineage.conditions,
        topics=" ".join(lineage.topics),
        t_start_ns=lineage.t_start_ns,
        t_end_ns=lineage.t_end_ns,
        software_version=software_version,
    )


def _field(value: Any) -> Any:
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str) and value.startswith(FORMULA):
        return f"'{value}"
    return "" if value is None else value
