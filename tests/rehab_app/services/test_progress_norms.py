"""The latest session beside the norms of the clinic: of its own numbers, cited, and only where known."""

from __future__ import annotations

import math

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from sessions.catalogue import TherapySession
from sessions.reports.past import Kept, Past, past_to_json, past_version

UTC_NS = 1_700_000_000_000_000_000


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path) as opened:
        yield opened


def treated(clinic, number, pip_deg):
    """A patient with one session whose numbers are kept."""
    patient = clinic.patients.add(
        CONSOLE, given_name="A", family_name=f"B{number}", birth_date="1955-05-06", side="right"
    ).id
    kept = (
        Kept("range_of_motion", "index_pip", math.radians(pip_deg), None, None, "ok", "1", "encoder"),
        Kept("joint_rmse", "index_pip", 0.1, None, None, "ok", "2", "encoder"),
    )
    past = Past(f"{number}", f"{number:064x}", patient, UTC_NS, "right", "grip", ("passive",), numbers=kept)
    clinic.catalogue.add_session(
        TherapySession(
            patient=patient,
            sha256=past.sha256,
            path=f"sessions/{number}.mcap",
            mode="passive",
            started_utc_ns=UTC_NS,
        )
    )
    clinic.catalogue.keep_metrics(past.sha256, past_version(), past_to_json(past))
    return patient


def test_a_range_stands_beside_the_norm_it_is_part_of(clinic):
    patients = [treated(clinic, number, 30.0 + 10.0 * number) for number in range(5)]
    assert clinic.progress.of_patient(patients[0]).norms == ()  # nobody made norms yet
    clinic.norms.renew(CONSOLE)
    (beside,) = clinic.progress.of_patient(patients[0]).norms  # an error has no norm
    assert (beside.name, beside.subject) == ("range_of_motion", "index_pip")
    assert math.degrees(beside.value) == pytest.approx(30.0)
    assert math.degrees(beside.median) == pytest.approx(50.0)
    assert beside.low < beside.median < beside.high
    assert beside.cited == "n = 5, this clinic, age 60-69"
    page = clinic.progress.rendered(clinic.progress.of_patient(patients[0]), "html").decode()
    assert "Beside patients alike of this clinic" in page
    assert "n = 5, this clinic, age 60-69; made" in page


def test_four_patients_are_no_norm(clinic):
    patients = [treated(clinic, number, 30.0) for number in range(4)]
    clinic.norms.renew(CONSOLE)
    assert clinic.progress.of_patient(patients[0]).norms == ()
