"""The first steps of a new clinic: add a patient, record, play; shown until each is done."""

from __future__ import annotations

from dataclasses import dataclass

from rehab_app.access import Verb
from rehab_app.web.language import marked
from rehab_app.web.visit import Visit


@dataclass(frozen=True, slots=True)
class FirstStep:
    """One of them.

    Attributes:
        path: Page where it is done.
        words: What is done.
        told: How.
        verb: What the role must allow.
    """

    path: str
    words: str
    told: str
    verb: Verb


STEPS = (
    FirstStep(
        "/patients/new",
        marked("Add a patient"),
        marked("Name, birth date and affected hand; then the diagnosis."),
        "prescribe",
    ),
    FirstStep(
        "/live#record",
        marked("Record a movement"),
        marked("Show it to the camera, look at the take and approve it."),
        "record",
    ),
    FirstStep(
        "/live",
        marked("Play it"),
        marked("Choose the patient and the take, compare the name, rehearse and play."),
        "play",
    ),
)


def first_steps(visit: Visit) -> tuple[tuple[FirstStep, bool], ...]:
    """The steps, and whether each is done; none once all are, or for a role that does none of them."""
    if not any(visit.account.may(step.verb) for step in STEPS):
        return ()
    begun = visit.site.clinic.catalogue.begun()
    done = (begun.patients, begun.takes, begun.sessions)
    return () if all(done) else tuple(zip(STEPS, done, strict=True))
