"""Keeps what assessments found, beside the sealed sessions that they were read from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import msgspec

from rehab_app.access import Account
from rehab_app.services.assessed import device_ends
from rehab_app.services.audit import Audit
from rehab_app.services.protocol_results import ProtocolResult, ranges_of
from rehab_app.services.rows import PreparedPlan
from rehab_app.therapy.run import PlayResult
from robot_iface.motion.limits import SweepResult
from sessions.catalogue import Catalogue, PatientEntry

ENCODER = "Angles are the device's encoders': straps and a displaced axis are not in them."
_KIND = "assessment"


@dataclass(frozen=True, slots=True)
class KeptResult:
    """A result with who made it and when.

    Attributes:
        id: Number of the entry.
        result: The result.
        by: Who assessed.
        utc_ns: When.
    """

    id: int
    result: ProtocolResult
    by: str
    utc_ns: int


class ProtocolRecords:
    """Results of assessments. Entries are added, none is changed.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where assessments are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit

    def keep_range(
        self, actor: Account, prepared: PreparedPlan, run: PlayResult, found: SweepResult
    ) -> KeptResult:
        """Keep the ranges of a sweep, wherever it was started from."""
        result = ProtocolResult(
            **where(prepared, run),
            protocol="range",
            ranges=ranges_of(found),
            notes=(ENCODER, *device_ends(found)),
        )
        return self.keep(actor, prepared, result)

    def keep(self, actor: Account, prepared: PreparedPlan, result: ProtocolResult) -> KeptResult:
        """Keep a result."""
        entry = PatientEntry(
            patient=prepared.patient_id,
            kind=_KIND,
            topic=result.protocol,
            session=result.session,
            content=msgspec.json.encode(result).decode(),
            by=actor.name,
        )
        kept = self._catalogue.add_entry(entry)
        said = f"{result.protocol}, session {result.session}"
        self._audit.note(actor, "assess", prepared.patient_id, said)
        return _kept(kept)

    def history(self, patient_id: str, protocol: str = "") -> tuple[KeptResult, ...]:
        """Results of a patient, newest first.

        Raises:
            Refused: The patient is unknown.
        """
        rows = self._catalogue.entries(patient_id, [_KIND], topic=protocol)
        return tuple(_kept(row) for row in rows)


def where(prepared: PreparedPlan, run: PlayResult) -> dict[str, Any]:
    """What all protocols note of where and on what."""
    return {
        "session": run.session,
        "device": prepared.plan.device,
        "side": prepared.plan.side,
        "wrist_rad": prepared.plan.wrist_rad,
    }


def _kept(row: PatientEntry) -> KeptResult:
    result = msgspec.json.decode(row.content, type=ProtocolResult)
    return KeptResult(row.id, result, row.by, row.created_utc_ns)
