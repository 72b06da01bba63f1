"""The head that every page of one patient wears: who it is, and the way to the other pages."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, date, datetime

from starlette.routing import Route

from rehab_app.web.language import _, marked
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient

_TABS: tuple[tuple[str, str], ...] = (
    ("", marked("Overview")),
    ("diagnosis", marked("Diagnosis")),
    ("limits", marked("Limits")),
    ("plan", marked("Plan")),
    ("progress", marked("Progress")),
    ("assessments", marked("Assessments")),
    ("outcomes", marked("Outcomes")),
    ("journal", marked("Journal")),
    ("sessions", marked("Sessions and takes")),
    ("data", marked("Data")),
)


@dataclass(frozen=True, slots=True)
class Tab:
    """A link to a page of the patient.

    Attributes:
        key: Last part of its path, empty for the overview.
        path: The path.
        words: What stands on it.
    """

    key: str
    path: str
    words: str


@dataclass(frozen=True, slots=True)
class PatientHead:
    """What stands above every page of a patient.

    Attributes:
        patient: The patient.
        here: Key of the tab that is shown.
        tabs: Tabs whose pages exist.
        age_years: Age today, None where no birth date is known.
    """

    patient: Patient
    here: str
    tabs: tuple[Tab, ...]
    age_years: int | None

    def has(self, key: str) -> bool:
        """Whether a tab exists."""
        return any(tab.key == key for tab in self.tabs)


def patient_head(visit: Visit, patient: Patient, here: str = "") -> PatientHead:
    """The head of a patient's page; tabs whose routes do not exist are left out.

    Args:
        visit: The request.
        patient: The patient.
        here: Key of the tab that is shown, "" for the overview.
    """
    known = {route.path for route in visit.request.app.routes if isinstance(route, Route)}
    tabs = tuple(
        Tab(key, f"/patients/{patient.id}" + (f"/{key}" if key else ""), _(words))
        for key, words in _TABS
        if not key or f"/patients/{{patient}}/{key}" in known
    )
    return PatientHead(
        patient, here, tabs, age_years(patient.birth_date, datetime.now(UTC).astimezone().date())
    )


def age_years(birth_date: str, today: date) -> int | None:
    """Whole years since an ISO date, None for an empty one."""
    if not birth_date:
        return None
    born = date.fromisoformat(birth_date)
    return today.year - born.year - ((today.month, today.day) < (born.month, born.day))
