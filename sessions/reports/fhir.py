"""Writes a report as a FHIR R4B bundle, which the library's models validate before a byte leaves here.

Patient by pseudonym, Procedure, one Observation per number with UCUM units, DiagnosticReport with the PDF
inside, Device, Provenance with the file's digest, and the code system that the codes are from. No code of
somebody else's terminology is used for a number: none of them means exactly these.
"""

from __future__ import annotations

import base64
import hashlib
import time
from typing import Any

from sessions.metrics import Summary, definition
from sessions.reports.fhir_observations import CODES, METRICS, moment, observation, period, reference
from sessions.reports.pdf import render_pdf
from sessions.reports.report import Report

PSEUDONYMS = "urn:rehab-app:pseudonym"
DIGESTS = "urn:rehab-app:sha256"


def render_fhir(report: Report, made_utc_ns: int | None = None) -> bytes:
    """The report as UTF-8 JSON of one Bundle.

    Args:
        report: What was measured.
        made_utc_ns: When the bundle is made; by default now. The same time gives the same bytes.
    """
    from fhir.resources.R4B.bundle import Bundle

    content = bundle(report, time.time_ns() if made_utc_ns is None else made_utc_ns)
    checked: Any = Bundle.model_validate(content)
    return str(checked.model_dump_json()).encode() + b"\n"


def bundle(report: Report, made_utc_ns: int) -> dict[str, Any]:
    """The bundle as plain values."""
    made = moment(made_utc_ns)
    device = _device(report.software_version)
    entries = [device, _code_system(report)]
    for subject in dict.fromkeys(summary.header.subject_id for summary in report.summaries):
        entries.append(_patient(subject))
    for summary in report.summaries:
        entries += _of_file(summary, Report((summary,), report.software_version), device, made)
    return {
        "resourceType": "Bundle",
        "type": "collection",
        "timestamp": made,
        "entry": [{"fullUrl": f"urn:uuid:{entry['id']}", "resource": entry} for entry in entries],
    }


def _of_file(summary: Summary, alone: Report, device: dict[str, Any], made: str) -> list[dict[str, Any]]:
    patient = _patient(summary.header.subject_id)
    procedure = _procedure(summary, patient, device)
    numbers = [observation(summary, item, patient, procedure, device) for item in summary.metrics]
    told = _diagnostic_report(summary, alone, patient, numbers, made)
    return [procedure, *numbers, told, _provenance(summary, told, device, made)]


def _patient(subject_id: str) -> dict[str, Any]:
    content: dict[str, Any] = {"resourceType": "Patient", "id": reference("patient", subject_id)}
    if subject_id:
        content["identifier"] = [{"system": PSEUDONYMS, "value": subject_id}]
    return content


def _device(version: str) -> dict[str, Any]:
    return {
        "resourceType": "Device",
        "id": reference("device", version),
        "deviceName": [{"name": "rehab-app", "type": "user-friendly-name"}],
        "version": [{"value": version}],
        "note": [{"text": "Not a certified medical device."}],
    }


def _procedure(summary: Summary, patient: dict[str, Any], device: dict[str, Any]) -> dict[str, Any]:
    header = summary.header
    kind = "recorded-movement" if header.kind == "take" else "hand-therapy"
    words = "Recorded movement" if header.kind == "take" else "Robot-assisted hand therapy"
    content: dict[str, Any] = {
        "resourceType": "Procedure",
        "id": reference("procedure", summary.sha256),
        "identifier": [{"system": DIGESTS, "value": summary.sha256}],
        "status": "stopped" if summary.stops else "completed",
        "code": {
            "coding": [{"system": CODES, "code": kind, "display": words}],
            "text": header.exercise or words,
        },
        "subject": {"reference": f"urn:uuid:{patient['id']}"},
        "performedPeriod": period(header, header.monotonic_start_ns, summary.duration_s),
        "bodySite": [{"text": f"{header.side} hand"}],
        "usedReference": [{"reference": f"urn:uuid:{device['id']}"}],
    }
    notes = [stop.text or stop.cause for stop in summary.stops]
    notes += [f"Support: {summary.conditions}"] if summary.conditions else []
    if notes:
        content["note"] = [{"text": text} for text in notes]
    return content


def _diagnostic_report(
    summary: Summary, alone: Report, patient: dict[str, Any], numbers: list[dict[str, Any]], made: str
) -> dict[str, Any]:
    paper = render_pdf(alone)
    digest = hashlib.sha1(paper, usedforsecurity=False).digest()  # FHIR's Attachment.hash is SHA-1
    return {
        "resourceType": "DiagnosticReport",
        "id": reference("report", summary.sha256),
        "status": "final",
        "code": {"coding": [{"system": CODES, "code": "report", "display": "Hand movement report"}]},
        "subject": {"reference": f"urn:uuid:{patient['id']}"},
        "effectivePeriod": period(summary.header, summary.header.monotonic_start_ns, summary.duration_s),
        "issued": made,
        "result": [{"reference": f"urn:uuid:{number['id']}"} for number in numbers],
        "presentedForm": [
            {
                "contentType": "application/pdf",
                "language": "en",
                "data": base64.b64encode(paper).decode(),
                "size": len(paper),
                "hash": base64.b64encode(digest).decode(),
                "title": "Report",
            }
        ],
    }


def _provenance(summary: Summary, told: dict[str, Any], device: dict[str, Any], made: str) -> dict[str, Any]:
    file = {"identifier": {"system": DIGESTS, "value": summary.sha256}, "display": "session file (MCAP)"}
    kinds = "http://terminology.hl7.org/CodeSystem/provenance-participant-type"
    return {
        "resourceType": "Provenance",
        "id": reference("provenance", summary.sha256),
        "target": [{"reference": f"urn:uuid:{told['id']}"}],
        "recorded": made,
        "agent": [
            {
                "type": {"coding": [{"system": kinds, "code": "assembler"}]},
                "who": {"reference": f"urn:uuid:{device['id']}"},
            }
        ],
        "entity": [{"role": "source", "what": file}],
    }


def _code_system(report: Report) -> dict[str, Any]:
    names = sorted({item.name for summary in report.summaries for item in summary.metrics})
    known = [definition(name) for name in names]
    return {
        "resourceType": "CodeSystem",
        "id": reference("codes", report.software_version),
        "url": METRICS,
        "version": report.software_version,
        "name": "RehabAppMetrics",
        "status": "active",
        "content": "fragment",
        "concept": [
            {"code": item.name, "display": item.title, "definition": f"{item.meaning} Method {item.version}."}
            for item in known
        ],
    }
