"""One number as a FHIR Observation: UCUM unit, 95 % interval, what measured it, why there is none."""

from __future__ import annotations

import uuid
from datetime import UTC, datetime
from typing import Any

from sessions.metrics import Metric, Summary, definition
from sessions.records import SessionHeader

METRICS = "urn:rehab-app:metrics"
CODES = "urn:rehab-app:codes"
UCUM = "http://unitsofmeasure.org"
UCUM_OF = {
    "rad": "rad",
    "m": "m",
    "m/s": "m/s",
    "s": "s",
    "Hz": "Hz",
    "Nm": "N.m",
    "Nm/rad": "N.m/rad",
    "J": "J",
    "1": "1",
}
"""UCUM code of each unit in the table of metrics; the units that metrics may add are one of its own kind."""
_ABSENT = "http://terminology.hl7.org/CodeSystem/data-absent-reason"
_CATEGORY = "http://terminology.hl7.org/CodeSystem/observation-category"
_SPACE = uuid.UUID("3b8c3a51-6a0b-5c6e-9a53-0f6a9f3c7d10")


def observation(
    summary: Summary,
    item: Metric,
    patient: dict[str, Any],
    procedure: dict[str, Any],
    device: dict[str, Any],
) -> dict[str, Any]:
    """One metric; a number that cannot be had is absent, with the reason in words."""
    known = definition(item.name)
    lineage, header = item.lineage, summary.header
    seconds = max(0, lineage.t_end_ns - lineage.t_start_ns) / 1e9
    category = "exam" if header.kind == "take" else "therapy"
    content: dict[str, Any] = {
        "resourceType": "Observation",
        "id": reference("observation", f"{summary.sha256}/{item.name}/{item.subject}"),
        "status": "final",
        "category": [{"coding": [{"system": _CATEGORY, "code": category}]}],
        "code": {
            "coding": [
                {"system": METRICS, "version": item.version, "code": item.name, "display": known.title}
            ],
            "text": f"{known.title}, {item.subject.replace('_', ' ')}",
        },
        "subject": {"reference": f"urn:uuid:{patient['id']}"},
        "partOf": [{"reference": f"urn:uuid:{procedure['id']}"}],
        "device": {"reference": f"urn:uuid:{device['id']}"},
        "method": {"text": _method(item)},
        "effectivePeriod": period(header, lineage.t_start_ns or header.monotonic_start_ns, seconds),
    }
    if item.subject != "whole":
        content["bodySite"] = {
            "coding": [{"system": CODES, "code": item.subject}],
            "text": f"{header.side} hand, {item.subject.replace('_', ' ')}",
        }
    return content | _value(item)


def period(header: SessionHeader, start_ns: int, seconds: float) -> dict[str, str]:
    """A span of a file in UTC.

    Args:
        header: The file's header, which pairs its clock with UTC.
        start_ns: Start on the file's monotonic clock.
        seconds: Length.
    """
    start = header.utc_start_ns + start_ns - header.monotonic_start_ns
    return {"start": moment(start), "end": moment(start + round(seconds * 1e9))}


def moment(utc_ns: int) -> str:
    """A FHIR instant, to the millisecond."""
    return datetime.fromtimestamp(utc_ns / 1e9, tz=UTC).isoformat(timespec="milliseconds")


def reference(kind: str, key: str) -> str:
    """The id of a resource: the same thing has the same one in every bundle."""
    return str(uuid.uuid5(_SPACE, f"{kind}/{key}"))


def _value(item: Metric) -> dict[str, Any]:
    if not item.measurable:
        reason = item.status.partition(": ")[2]
        return {"dataAbsentReason": {"coding": [{"system": _ABSENT, "code": "unknown"}], "text": reason}}
    content: dict[str, Any] = {"valueQuantity": _quantity(item.value, item.unit)}
    if item.interval is not None:
        content["component"] = [
            {
                "code": {"coding": [{"system": CODES, "code": code, "display": words}]},
                "valueQuantity": _quantity(end, item.unit),
            }
            for end, code, words in zip(
                item.interval,
                ("interval-low", "interval-high"),
                ("Lower end of the 95 % interval", "Upper end of the 95 % interval"),
                strict=True,
            )
        ]
    if item.status != "ok":
        content["note"] = [{"text": item.status.partition(": ")[2]}]
    return content


def _quantity(value: float, unit: str) -> dict[str, Any]:
    quantity: dict[str, Any] = {"value": round(value, 12), "unit": unit}
    if unit in UCUM_OF:
        quantity |= {"system": UCUM, "code": UCUM_OF[unit]}
    return quantity


def _method(item: Metric) -> str:
    parts = [f"{item.name} version {item.version}", f"measured by {item.lineage.source or 'unknown'}"]
    return "; ".join([*parts, item.lineage.conditions] if item.lineage.conditions else parts)
