"""A clinic to look at: people who do not exist, simulated devices, everything a page may show."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.clinic import Clinic
from rehab_app.services.journal_records import AdverseEvent, PainReport
from rehab_app.services.order import Order
from rehab_app.services.plan_items import Plan, PlanItem
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.services.retouching import Wish
from sessions.catalogue import ClinicalRecord

PASSWORD = "a hand that opens"
ADMINISTRATOR, THERAPIST, PATIENT = "ada", "anna", "screen-1"
SEED = 7
PEOPLE = (
    ("Clara", "Weber", "1957-03-14", "right", 0.185, "Weak grasp, opening harder than closing"),
    ("Tomás", "Ferreira", "1949-11-02", "left", 0.196, "Stiff after fracture"),
    ("Noor", "van Dijk", "1983-06-21", "right", 0.172, "Flexor tendon repair, index"),
    ("Edwin", "Okafor", "1971-01-30", "left", 0.204, ""),
    ("Giulia", "Conti", "2001-09-09", "right", 0.168, "Ulnar nerve, weak spread"),
)
OUTCOMES = (
    ("fma-hand", 6.0, 28),
    ("fma-hand", 9.0, 1),
    ("box-and-block", 14.0, 28),
    ("box-and-block", 21.0, 1),
)


@dataclass(frozen=True, slots=True)
class Seeded:
    """What the pages are asked for.

    Attributes:
        patient: Pseudonym of the patient with everything.
        take: The approved take; it holds pictures.
        retouched: A slower take made of it.
        session: The newest played session.
        earlier: The first one.
    """

    patient: str
    take: str
    retouched: str
    session: str
    earlier: str

    def fill(self, path: str) -> str:
        """A path with the ids in their places."""
        for name in ("patient", "take", "retouched", "session", "earlier"):
            path = path.replace("{" + name + "}", getattr(self, name))
        return path


def seed(folder: Path) -> Seeded:
    """Make the clinic in an empty folder; takes about a minute."""
    with open_clinic(folder) as clinic:
        clinic.presentation.set_name(CONSOLE, "Riverside Hand Clinic (example)")
        patients = [_person(clinic, *person) for person in PEOPLE]
        clinic.accounts.add_user(ADMINISTRATOR, "administrator", PASSWORD, CONSOLE)
        clinic.accounts.add_user(THERAPIST, "therapist", PASSWORD, CONSOLE)
        clinic.accounts.add_user("aldo", "assistant", PASSWORD, CONSOLE)
        clinic.accounts.add_user(PATIENT, "patient", PASSWORD, CONSOLE, patients[0])
        _record(clinic, patients[0])
        take, retouched = _takes(clinic)
        _plan(clinic, patients[0])
        earlier, *_, newest = _therapy(clinic, patients[0], take)
        return Seeded(patients[0], take, retouched, newest, earlier)


def _person(
    clinic: Clinic, given: str, family: str, born: str, side: str, length_m: float, impairment: str
) -> str:
    return clinic.patients.add(
        CONSOLE,
        given_name=given,
        family_name=family,
        birth_date=born,
        side=side,
        hand_length_m=length_m,
        impairment=impairment,
    ).id


def _record(clinic: Clinic, patient: str) -> None:
    """Diagnosis, journal and outcomes of the last weeks."""
    stroke = _days_ago(120)
    clinic.clinical.state(
        CONSOLE, ClinicalRecord(patient=patient, diagnosis="stroke", event_date=stroke, mas="1", by="anna")
    )
    clinic.journal.note(CONSOLE, patient, "Opens better after the warm-up; thumb still follows late.")
    clinic.journal.pain(CONSOLE, patient, PainReport(2, "thumb base", "after", "gone after ten minutes"))
    event = AdverseEvent(
        "mild", "Strap marked the skin of the index.", "Strap moved, skin clear after 15 min."
    )
    clinic.journal.adverse_event(CONSOLE, patient, event)
    for key, value, days in OUTCOMES:
        clinic.outcomes.add(CONSOLE, patient, key, value, side="right", measured_on=_days_ago(days))
    clinic.outcomes.add(CONSOLE, patient, "pain-after", 2.0, measured_on=_days_ago(1))


def _takes(clinic: Clinic) -> tuple[str, str]:
    """An approved take, and a slower one made of it."""
    wanted = RecordingRequest(
        exercise="open_close", side="right", seconds=6.0, consent_images=True, seed=SEED
    )
    take = clinic.takes.record(wanted, CONSOLE).take
    clinic.takes.approve(take, CONSOLE)
    slower = clinic.retouching.retouch(
        take, Wish(trim_s=(0.5, 5.0)), "The first half second is reaching.", actor=CONSOLE
    )
    clinic.takes.record_virtual("pinch", "right", 4.0, SEED, CONSOLE)
    return take, slower.id


def _plan(clinic: Clinic, patient: str) -> None:
    items = (
        PlanItem(exercise="open_close", part="warm-up", speed=0.3, repetitions=5, minutes=3.0),
        PlanItem(exercise="open_close", mode="assistive", speed=0.5, repetitions=20, minutes=10.0),
        PlanItem(exercise="pinch", part="task", mode="assistive", speed=0.4, repetitions=10, minutes=5.0),
    )
    goal = "Hold a glass of water with the right hand."
    clinic.plans.change(CONSOLE, Plan(patient=patient, items=items, sessions_per_week=4, goal=goal))


def _therapy(clinic: Clinic, patient: str, take: str) -> list[str]:
    """Limits measured, then three sessions, which are returned."""
    clinic.protocols.range(CONSOLE, patient, Order(seed=SEED, twin="weak"), present=patient)
    made: list[str] = []
    for number, mode in enumerate(("passive", "assistive", "assistive")):
        order = Order(mode=mode, speed=0.6, repetitions=4, twin="weak", seed=SEED + number)
        plan = clinic.therapy.plan(take, order, actor=CONSOLE, patient_id=patient)
        made.append(clinic.therapy.rehearse_and_play(plan, actor=CONSOLE, present=patient).session)
    return made


def _days_ago(days: int) -> str:
    return (datetime.now(tz=UTC) - timedelta(days=days)).date().isoformat()
