"""Brings a row that waited into the catalogue, exactly once, with the time at which it was made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import Any, TypeVar

import msgspec

from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.outbox_folder import Waiting
from sessions.catalogue import (
    AssistanceMemory,
    Catalogue,
    DayLimits,
    FitCheck,
    Hand,
    PatientEntry,
    PrescriptionRow,
    Take,
    TherapySession,
)

V = TypeVar("V")
LATER_ENTRIES = ("note", "pain", "adverse-event", "check-in", "assessment")
"""What is written during a session; a plan, a consent or a proposal is decided where all can be read."""
_WHOSE = ("patient", "person", "subject_id")


def deliver(catalogue: Catalogue, row: Waiting) -> None:
    """Write a row that waited; one that arrived before is not written again.

    Args:
        catalogue: The catalogue, whose verbs write and do not put off.
        row: The row.

    Raises:
        Refused: The catalogue does not answer, or it cannot take the row any more; nothing was written.
    """
    bring = _BRINGERS.get(row.kind)
    if bring is None:
        raise _damaged(f"of kind {row.kind[:40]!r}")
    time_of_rows_ns = 0 if row.kind in ("audit", "sign-out") else row.utc_ns
    with catalogue.once(row.id, time_of_rows_ns) as new:
        if new:
            _check_there(catalogue, row)
            bring(catalogue, row)


def erased(catalogue: Catalogue, row: Waiting) -> bool:
    """Whether a row is about somebody who was erased meanwhile.

    Raises:
        Refused: The catalogue does not answer.
    """
    try:
        found = catalogue.patient(_whose(row))
    except NoAnswer:
        raise
    except Refused:  # a therapist's hand, or nobody's
        return False
    return found.archived and not (found.family_name or found.given_name or found.birth_date)


def bare(row: Waiting) -> Waiting:
    """What may be kept of a row about somebody who was erased: where the recording lies, else nothing."""
    path = row.content.get("path")
    return Waiting(row.id, row.kind, row.utc_ns, {"path": path} if isinstance(path, str) else {})


def _whose(row: Waiting) -> str:
    return next((str(row.content[name]) for name in _WHOSE if row.content.get(name)), "")


def _check_there(catalogue: Catalogue, row: Waiting) -> None:
    if erased(catalogue, row):
        raise Refused(
            f"{row.kind} of {_whose(row)}",
            "about a patient who was erased meanwhile",
            "about a patient of this clinic",
            f"delete {row.content.get('path', 'it')} from the clinic folder",
        )


def _value(kind: type[V], content: Mapping[str, Any]) -> V:
    """The frozen value again.

    Raises:
        Refused: It is not one.
    """
    try:
        return msgspec.convert(content, kind)
    except (msgspec.ValidationError, TypeError) as error:
        raise _damaged(str(error)) from error


def _damaged(how: str) -> Refused:
    return Refused("row that waited", f"damaged ({how[:200]})", "as it was written", "enter it by hand")


def _bring_take(catalogue: Catalogue, row: Waiting) -> None:
    catalogue.add_take(_value(Take, row.content))


def _bring_session(catalogue: Catalogue, row: Waiting) -> None:
    catalogue.add_session(_value(TherapySession, row.content))


def _bring_entry(catalogue: Catalogue, row: Waiting) -> None:
    catalogue.add_entry(_value(PatientEntry, row.content))


def _bring_fit(catalogue: Catalogue, row: Waiting) -> None:
    catalogue.add_fit_check(_value(FitCheck, row.content))


def _bring_hand(catalogue: Catalogue, row: Waiting) -> None:
    catalogue.add_hand(_value(Hand, row.content))


def _bring_prescription(catalogue: Catalogue, row: Waiting) -> None:
    catalogue.add_prescription(_value(PrescriptionRow, row.content))


def _bring_assistance(catalogue: Catalogue, row: Waiting) -> None:
    memory = _value(AssistanceMemory, row.content)
    newest = catalogue.assistance(memory.patient, memory.exercise, memory.device)
    if newest is not None and newest.created_utc_ns > row.utc_ns:
        raise _overtaken("remembered assistance", memory.patient)
    catalogue.add_assistance(memory)


def _bring_limits(catalogue: Catalogue, row: Waiting) -> None:
    limits = _value(DayLimits, row.content)
    held = catalogue.day_limits(limits.patient, limits.device)
    if held and held[0].measured_utc_ns > limits.measured_utc_ns:
        raise _overtaken("limits", limits.patient)
    catalogue.add_day_limits(limits)


def _bring_sign_out(catalogue: Catalogue, row: Waiting) -> None:
    catalogue.end_sign_ins(str(row.content.get("user", "")), str(row.content.get("digest", "")))


def _bring_audit(catalogue: Catalogue, row: Waiting) -> None:
    """The chain follows the order of arrival; when it was done is said in the detail."""
    at = datetime.fromtimestamp(row.utc_ns / 1e9, tz=UTC).isoformat(timespec="milliseconds")
    kept = _value(_AuditRows, row.content).rows
    said = f"done at {at} while the catalogue did not answer"
    catalogue.record_audit_rows(
        (actor, verb, subject, f"{detail}; {said}" if detail else said)
        for actor, verb, subject, detail in kept
    )


class _AuditRows(msgspec.Struct, frozen=True):
    """Rows of the audit: who, verb, subject, detail."""

    rows: list[tuple[str, str, str, str]]


def _overtaken(thing: str, patient: str) -> Refused:
    return Refused(
        f"{thing} of {patient}", "older than what is there by now", "the newest", "nothing: the newest holds"
    )


_BRINGERS: dict[str, Callable[[Catalogue, Waiting], None]] = {
    "take": _bring_take,
    "session": _bring_session,
    "entry": _bring_entry,
    "fit-check": _bring_fit,
    "hand": _bring_hand,
    "prescription": _bring_prescription,
    "assistance": _bring_assistance,
    "limits": _bring_limits,
    "sign-out": _bring_sign_out,
    "audit": _bring_audit,
}
