"""Renders a report as JSON in SI units: for programs, and for the command line's ``--json``."""

from __future__ import annotations

import json
import math
from typing import Any

from sessions.metrics import Lineage, Metric, Repetition, Summary
from sessions.records import DIGITS
from sessions.reports.report import Report


def report_object(report: Report) -> dict[str, Any]:
    """The report as plain values; a number that cannot be had is None, and its status says why."""
    return {
        "metrics": [_metric(item) for summary in report.summaries for item in summary.metrics],
        "sessions": [_session(summary) for summary in report.summaries],
        "software_version": report.software_version,
    }


def render_json(report: Report) -> bytes:
    """The report as UTF-8 JSON; the same report gives the same bytes."""
    text = json.dumps(report_object(report), ensure_ascii=False, allow_nan=False, indent=1)
    return text.encode() + b"\n"


def _metric(item: Metric) -> dict[str, Any]:
    return {
        "name": item.name,
        "subject": item.subject,
        "value": _number(item.value),
        "unit": item.unit,
        "interval": None if item.interval is None else list(item.interval),
        "version": item.version,
        "status": item.status,
        "lineage": _lineage(item.lineage),
    }


def _lineage(lineage: Lineage) -> dict[str, Any]:
    return {
        "file_sha256": lineage.file_sha256,
        "topics": list(lineage.topics),
        "t_start_ns": lineage.t_start_ns,
        "t_end_ns": lineage.t_end_ns,
        "source": lineage.source,
        "conditions": lineage.conditions,
    }


def _session(summary: Summary) -> dict[str, Any]:
    header = summary.header
    return {
        "session_id": header.session_id,
        "kind": header.kind,
        "subject_id": header.subject_id,
        "side": header.side,
        "exercise": header.exercise,
        "source": header.source,
        "file_sha256": summary.sha256,
        "passive_run_sha256": summary.passive_sha256 or None,
        "parents": list(header.parents),
        "utc_start_ns": header.utc_start_ns,
        "duration_s": summary.duration_s,
        "recorded_by_version": header.software_version,
        "modes": list(summary.modes),
        "stiffness": summary.conditions or None,
        "repetitions": [_repetition(item) for item in summary.repetitions],
        "stops": [
            {"t_s": stop.t_s, "cause": stop.cause, "category": stop.category, "text": stop.text}
            for stop in summary.stops
        ],
    }


def _repetition(item: Repetition) -> dict[str, Any]:
    return {
        "index": item.index,
        "t_start_s": item.t_start_s,
        "t_end_s": item.t_end_s,
        "started_by": item.started_by,
        "completed": item.completed,
        "rmse_rad": _number(item.rmse_rad),
        "fingertip_rmse_m": _number(item.fingertip_rmse_m),
        "assistance": {digit: _number(value) for digit, value in zip(DIGITS, item.assistance, strict=True)},
        "robot_share": _number(item.robot_share),
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
