"""Every mode that a diagnosis closes at first: until when, to protect what, and who opened it earlier."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date, timedelta

from rehab_app.services.diagnosis import allow, templates_of, unlock_of
from rehab_app.services.diagnosis_templates import BY_ACT_ONLY, Lock, Template
from robot_iface.types import MODES, Mode
from sessions.catalogue import ClinicalRecord, ModeUnlock


@dataclass(frozen=True, slots=True)
class ModeLock:
    """A mode that a template of a patient's record names.

    Attributes:
        mode: Therapy mode.
        diagnosis: Key of the template that holds longest.
        why: What the lock protects, in a few words.
        event: What the days are counted from, as the template words it.
        from_day: Day on which it opens; infinite where only a therapist's act opens it.
        opens_on: ISO date on which it opens; empty where nobody knows, or none does.
        locked: Whether it is locked today.
        unlock: The act by which it is open before its date, else None.
    """

    mode: Mode
    diagnosis: str
    why: str
    event: str
    from_day: float
    opens_on: str
    locked: bool
    unlock: ModeUnlock | None

    @property
    def by_act_only(self) -> bool:
        """Whether no date opens it."""
        return self.from_day == BY_ACT_ONLY


def mode_locks(record: ClinicalRecord, unlocks: Iterable[ModeUnlock], today: date) -> tuple[ModeLock, ...]:
    """The modes that a record closes at first, in the order of the modes; open ones are left out.

    Args:
        record: The newest clinical record.
        unlocks: Decisions about this patient's modes, newest first.
        today: Today's date where the patient is.
    """
    decided = tuple(unlocks)
    found = (_lock(record, decided, mode, today) for mode in MODES)
    return tuple(one for one in found if one is not None)


def _lock(
    record: ClinicalRecord, unlocks: tuple[ModeUnlock, ...], mode: Mode, today: date
) -> ModeLock | None:
    """The lock of one mode, that of the template which opens it last; None where no template has one."""
    held = [(one, lock) for one in templates_of(record) for lock in one.locks if lock.mode == mode]
    if not held:
        return None
    chosen, lock = max(held, key=lambda pair: pair[1].from_day)
    refused = any(allow(one, mode, record.event_date, today) is not None for one, _ in held)
    unlock = unlock_of(record, unlocks, mode) if refused else None
    return ModeLock(
        mode=mode,
        diagnosis=chosen.key,
        why=lock.why,
        event=chosen.event,
        from_day=lock.from_day,
        opens_on=_opens_on(chosen, lock, record.event_date),
        locked=refused and unlock is None,
        unlock=unlock,
    )


def _opens_on(chosen: Template, lock: Lock, event_date: str) -> str:
    if lock.from_day == BY_ACT_ONLY or not event_date or not chosen.event:
        return ""
    return (date.fromisoformat(event_date) + timedelta(days=math.ceil(lock.from_day))).isoformat()
