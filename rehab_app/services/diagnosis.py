"""What a patient's clinical record means for therapy: locked modes, halved torque, speed, skin checks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date, timedelta

from rehab_app.errors import Refused
from rehab_app.services.diagnosis_templates import BY_ACT_ONLY, KEYS, SKIN_CHECK_S, TEMPLATES, Lock, Template
from robot_iface.types import MODES, Mode, VirtualKind
from sessions.catalogue import ClinicalRecord, ModeUnlock

_SPASTIC_GRADES = ("1+", "2", "3", "4")
_RIGID_NM_RAD = 0.9  # of an MCP joint, the stiffest of the published sample; Ashworth 4 has no virtual kind


@dataclass(frozen=True, slots=True)
class Precautions:
    """What follows from a clinical record for every session.

    Attributes:
        halved: Torque limits are halved.
        spastic: Extension is slow, as with Modified Ashworth 1+ or more.
        hyperextension: Flexion joints may go below 0 degrees.
        skin_check_s: Motion time between looks at the skin, 0 for none.
        kind: Virtual patient that stands in for this one.
        stiffness_nm_rad: Its passive MCP stiffness, 0 for the kind's own.
        notes: The precautions as sentences.
        stated_utc_ns: When the record was stated, 0 for none; what was raised before holds no more.
    """

    halved: bool = False
    spastic: bool = False
    hyperextension: bool = False
    skin_check_s: float = 0.0
    kind: VirtualKind = "healthy"
    stiffness_nm_rad: float = 0.0
    notes: tuple[str, ...] = ()
    stated_utc_ns: int = 0


def template(key: str) -> Template:
    """The template of a diagnosis.

    Raises:
        Refused: There is none.
    """
    for one in TEMPLATES:
        if one.key == key:
            return one
    raise Refused("diagnosis", repr(key[:40]), "one of " + ", ".join(KEYS), "choose one of them")


def templates_of(record: ClinicalRecord) -> tuple[Template, ...]:
    """Every template that applies: that of the diagnosis, and those of what stands beside it."""
    keys = [record.diagnosis]
    keys += ["rheumatoid-arthritis"] if record.rheumatoid else []
    keys += ["crps"] if record.crps else []
    return tuple(template(key) for key in dict.fromkeys(keys))


def allow(chosen: Template, mode: Mode, event_date: str, today: date) -> Refused | None:
    """Whether a diagnosis lets a mode be used today.

    Args:
        chosen: Template of the diagnosis.
        mode: Therapy mode.
        event_date: ISO date of the event, empty if nobody knows it.
        today: Today's date where the patient is.

    Returns:
        None where it may, else the refusal with the day from which on it may.
    """
    lock = next((one for one in chosen.locks if one.mode == mode), None)
    if lock is None:
        return None
    thing = f"{mode} mode for {chosen.words}"
    ask = f"or have a therapist unlock {mode} (in the diagnosis, or rehab-app patient unlock)"
    if lock.from_day == BY_ACT_ONLY:
        return Refused(
            thing,
            f"locked, to protect {lock.why}",
            "unlocked by a therapist",
            f"choose another mode, {ask}",
        )
    if not event_date:
        bound = f"used from day {lock.from_day:.0f} after the {chosen.event} on, whose date is unknown"
        return Refused(thing, "locked", bound, f"enter its date in the diagnosis, {ask}")
    return _before(lock, thing, chosen, date.fromisoformat(event_date), today, ask)


def check_mode(
    record: ClinicalRecord, unlocks: Iterable[ModeUnlock], mode: Mode, today: date
) -> tuple[ModeUnlock, ...]:
    """Let a mode pass for a patient today.

    Args:
        record: The newest clinical record.
        unlocks: Decisions about this patient's locked modes, newest first.
        mode: Therapy mode.
        today: Today's date where the patient is.

    Returns:
        The unlock that opened it, where it is one.

    Raises:
        Refused: A template locks it and no therapist has unlocked it for this diagnosis and event.
    """
    refusals = [allow(one, mode, record.event_date, today) for one in templates_of(record)]
    locked = [refusal for refusal in refusals if refusal is not None]
    if not locked:
        return ()
    opened = unlock_of(record, unlocks, mode)
    if opened is None:
        raise locked[0]
    return (opened,)


def unlock_of(record: ClinicalRecord, unlocks: Iterable[ModeUnlock], mode: str) -> ModeUnlock | None:
    """The newest decision about a mode if it unlocks it for the record's diagnosis and event, else None."""
    for one in unlocks:
        if one.mode == mode:
            same = (one.diagnosis, one.event_date) == (record.diagnosis, record.event_date)
            return one if one.unlocked and same else None
    return None


def locks_of(record: ClinicalRecord, unlocks: tuple[ModeUnlock, ...], today: date) -> dict[str, str]:
    """Every mode that is locked today, with the sentence that says until when."""
    found: dict[str, str] = {}
    for mode in MODES:
        try:
            check_mode(record, unlocks, mode, today)
        except Refused as refusal:
            found[mode] = str(refusal)
    return found


def needs_own_range(record: ClinicalRecord, today: date) -> Template | None:
    """The template that refuses the shipped full range today, None where none does."""
    for one in templates_of(record):
        since = _days(record.event_date, today)
        if since < one.own_range_until_day:
            return one
    return None


def precautions(record: ClinicalRecord | None) -> Precautions:
    """What follows from a record for every session; nothing from none."""
    if record is None:
        return Precautions()
    applied = templates_of(record)
    ungraded = not record.mas and any(one.spastic for one in applied)
    halved = record.insensate or any(one.halved for one in applied)
    unfelt = record.insensate or record.unaware
    return Precautions(
        halved=halved,
        spastic=ungraded or record.mas in _SPASTIC_GRADES,
        hyperextension=record.hyperextension_allowed,
        skin_check_s=SKIN_CHECK_S if unfelt else max(one.skin_check_s for one in applied),
        kind=_kind(record, ungraded),
        stiffness_nm_rad=_RIGID_NM_RAD if record.mas == "4" else 0.0,
        notes=_notes(record, halved, ungraded, unfelt or any(one.skin_check_s for one in applied)),
        stated_utc_ns=record.created_utc_ns,
    )


def _kind(record: ClinicalRecord, ungraded: bool) -> VirtualKind:
    grades: dict[str, VirtualKind] = {"1+": "mas1+", "2": "mas2", "3": "mas3", "4": "mas3"}
    if ungraded:
        return "mas1+"
    if record.mas in grades:
        return grades[record.mas]
    return "contracture" if record.diagnosis == "burn" else "healthy"


def _notes(record: ClinicalRecord, halved: bool, ungraded: bool, skin: bool) -> tuple[str, ...]:
    told = (
        (halved, "Torque limits are halved by the clinical record."),
        (ungraded, "Nobody has graded the tone after the stroke: it counts as spastic."),
        (skin, f"The skin must be looked at every {SKIN_CHECK_S / 60:.0f} minutes of motion."),
        (record.hyperextension_allowed, "Hyperextension is allowed by the clinical record."),
    )
    return tuple(words for holds, words in told if holds)


def _before(lock: Lock, thing: str, chosen: Template, event: date, today: date, ask: str) -> Refused | None:
    opens = event + timedelta(days=math.ceil(lock.from_day))
    if today >= opens:
        return None
    since = (today - event).days
    return Refused(
        thing,
        f"on day {since} after the {chosen.event} of {event.isoformat()}, to protect {lock.why}",
        f"used from {opens.isoformat()} (day {lock.from_day:.0f}) on",
        f"choose another mode, wait, {ask}",
    )


def _days(event_date: str, today: date) -> float:
    """Days since the event; as if it were today where nobody knows the date."""
    return 0.0 if not event_date else float((today - date.fromisoformat(event_date)).days)
