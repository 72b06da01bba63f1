"""Which passive runs of the catalogue may tell a session's recoil: same patient, same UTC day."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from sessions.catalogue import TherapySession

PASSIVE = "passive"
_DAY_NS = 86_400_000_000_000


def passive_runs(row: TherapySession, of_patient: Sequence[TherapySession]) -> tuple[TherapySession, ...]:
    """Passive sessions of the same patient and day, nearest in time first.

    Args:
        row: The session that is measured; a passive one needs none.
        of_patient: Sessions among which they are looked for.
    """
    if row.mode == PASSIVE or not row.patient:
        return ()
    found = [
        one
        for one in of_patient
        if one.mode == PASSIVE
        and one.patient == row.patient
        and one.id != row.id
        and one.started_utc_ns // _DAY_NS == row.started_utc_ns // _DAY_NS
    ]
    return tuple(sorted(found, key=lambda one: (abs(one.started_utc_ns - row.started_utc_ns), one.id)))


def key_of(version: str, runs: Sequence[TherapySession]) -> str:
    """Version under which numbers are kept that were measured beside these runs."""
    if not runs:
        return version
    named = ",".join(run.sha256 for run in runs)
    return f"{version}-{hashlib.sha256(named.encode()).hexdigest()[:16]}"
