"""Hazard 24: a patient is treated at two stations at once, or the wrong one is chosen in one of two rooms."""

from __future__ import annotations

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.order import Order
from rehab_app.services.station_claims import Claims, identity_of
from rehab_app.services.station_marks import StationMarks
from sessions.catalogue import Catalogue

ORDER = Order(speed=1.0, repetitions=1)


@pytest.fixture
def rooms(tmp_path):
    """A clinic with a patient and a plan, and the claims of another station on its catalogue."""
    with open_clinic(tmp_path / "clinic") as here, Catalogue.open(here.folder) as beside:
        patient = here.patients.add(
            CONSOLE, given_name="Ada", family_name="Nowhere", birth_date="1950-01-01", side="right"
        ).id
        here.takes.record_virtual("open_close", "right", 4.0, 4, CONSOLE)
        take = here.takes.list()[0].id
        here.takes.approve(take, CONSOLE)
        plan = here.therapy.plan(take, ORDER, actor=CONSOLE, patient_id=patient)
        audit = Audit(beside)
        there = Claims(
            beside,
            audit,
            identity_of("room-2", "1.0"),
            StationMarks(tmp_path / "room-2", "other"),
            60.0,
            20.0,
        )
        yield here, there, plan, patient
        there.close()
        audit.close()


def test_nothing_moves_for_a_patient_who_is_treated_elsewhere(rooms):
    here, there, plan, patient = rooms
    certificate = here.therapy.rehearse(plan, actor=CONSOLE)
    with there.held(patient):
        with pytest.raises(Refused, match="in therapy at station room-2 since"):
            here.therapy.play(plan, certificate, actor=CONSOLE)
        assert here.sessions.list() == ()
        assert not list((here.folder / "sessions").iterdir()), "something was recorded, so something moved"


def test_the_next_station_may_once_the_first_has_ended(rooms):
    here, there, plan, patient = rooms
    played = here.therapy.rehearse_and_play(plan, actor=CONSOLE)
    assert played.completed
    with there.held(patient):
        assert [claim.station for claim in here.catalogue.claims()] == ["room-2"]
