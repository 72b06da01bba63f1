"""What identifies a patient: read out of a form, and two people's changes brought together."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from rehab_app.errors import Refused
from rehab_app.services.patients import (
    HAND_LENGTH_M,
    LONGEST_NAME,
    LONGEST_NOTE,
    check_birth_date,
    side_named,
)
from rehab_app.services.plain_text import many_lines, needed, one_line
from rehab_app.web.language import written
from rehab_app.web.pages.asked import decimal
from rehab_app.web.pages.typed import Typed
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient

NAMES = ("given_name", "family_name", "birth_date", "side", "hand_length_cm", "impairment")
_USUAL_CM = 18.9
THINGS = {
    "patient's given name": "given_name",
    "patient's family name": "family_name",
    "birth date": "birth_date",
    "side": "side",
    "hand length": "hand_length_cm",
    "impairment and precautions": "impairment",
}
"""Field of the form by what a service refuses."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A field that somebody else changed while this person edited.

    Attributes:
        field: Its name.
        yours: What this person typed.
        theirs: What stands in the record now.
        clash: Whether both changed it; else theirs is in the form already.
    """

    field: str
    yours: str
    theirs: str
    clash: bool


def empty() -> dict[str, str]:
    """The form of a new patient."""
    return dict.fromkeys(NAMES, "") | {"hand_length_cm": written(_USUAL_CM)}


def shown(patient: Patient) -> dict[str, str]:
    """A patient as the form shows it."""
    return {
        "given_name": patient.given_name,
        "family_name": patient.family_name,
        "birth_date": patient.birth_date,
        "side": patient.side,
        "hand_length_cm": written(round(100 * patient.hand_length_m, 2)),
        "impairment": patient.impairment,
    }


def typed_patient(visit: Visit) -> tuple[Typed, Patient]:
    """The form and the patient in it; what is refused is kept in the form and stands as the default.

    The patient has the version from which the form was made, and no pseudonym.
    """
    form = Typed(visit, NAMES)
    patient = Patient(
        given_name=form.read("given_name", _given_name, ""),
        family_name=form.read("family_name", _family_name, ""),
        birth_date=form.read("birth_date", _birth_date, ""),
        side=form.read("side", side_named, "right"),
        hand_length_m=form.read("hand_length_cm", _length_m, 0.189),
        impairment=form.read("impairment", _impairment, ""),
    )
    version = visit.asked("version")
    known = version.isascii() and version.isdecimal() and len(version) < 10
    return form, replace(patient, version=int(version) if known else 0)


def merge(form: Typed, visit: Visit, now: Patient) -> tuple[Difference, ...]:
    """Bring a form together with what somebody else saved meanwhile.

    What only they changed is taken into the form; what both changed stays as it was typed, to be decided.

    Args:
        form: What was typed; its values are changed.
        visit: The request, whose ``was_...`` fields say what the form was made from.
        now: The record as it is.

    Returns:
        What they changed.
    """
    found: list[Difference] = []
    for name, theirs in shown(now).items():
        was, yours = visit.asked(f"was_{name}").replace("\r\n", "\n"), form.values[name]
        if theirs in (was, yours):
            continue
        clash = yours != was
        found.append(Difference(name, yours, theirs, clash))
        if not clash:
            form.values[name] = theirs
            form.problems.pop(name, None)
    return tuple(found)


def _given_name(text: str) -> str:
    return one_line("patient's given name", needed("given name", text), LONGEST_NAME)


def _family_name(text: str) -> str:
    return one_line("patient's family name", needed("family name", text), LONGEST_NAME)


def _birth_date(text: str) -> str:
    """An ISO date that somebody alive can have been born on."""
    needed("birth date", text)
    birth_date = Patient(side="right", birth_date=text).birth_date
    check_birth_date(birth_date, datetime.now(UTC).astimezone().date())
    return birth_date


def _length_m(text: str) -> float:
    """The length of a hand, typed in cm: refused in cm, too."""
    low_cm, high_cm = 100 * HAND_LENGTH_M[0], 100 * HAND_LENGTH_M[1]
    length_cm = decimal(text)
    if not low_cm <= length_cm <= high_cm:
        value = f"{length_cm:g} cm" if math.isfinite(length_cm) else repr(text[:40])
        bound = f"{low_cm:.0f} to {high_cm:.0f} cm"
        raise Refused("hand length", value, bound, "measure wrist crease to middle fingertip")
    return length_cm / 100.0


def _impairment(text: str) -> str:
    return many_lines("impairment and precautions", text, LONGEST_NOTE)
