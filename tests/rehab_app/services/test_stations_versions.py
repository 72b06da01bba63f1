"""Two stations change the same: the later writer is told, and what either wrote is kept or still at hand."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from rehab_app.access import Account
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.errors import Refused
from rehab_app.services.plan_items import PlanItem
from sessions.catalogue import RANGE_HIGH, RANGE_LOW, Catalogue, ClinicalRecord, LimitChange, Patient
from tests.contracts.test_catalogue import URLS

ANNA, BERT = Account("anna", "therapist", "1"), Account("bert", "therapist", "2")


@pytest.fixture(params=sorted(URLS))
def rooms(request, tmp_path):
    """Two stations with folders of their own on one data base."""
    url = URLS[request.param](tmp_path)
    opened = [
        open_clinic(tmp_path / name, settings=Settings(catalogue_url=url, station=name))
        for name in ("room-1", "room-2")
    ]
    yield opened
    for clinic in opened:
        clinic.close()


@pytest.fixture
def patient(rooms):
    return rooms[0].catalogue.add_patient(Patient(side="right")).id


def meet(monkeypatch, verb):
    """Both writers have read before either writes: the race that a lock within one process cannot see."""
    gate, write = threading.Barrier(2, timeout=30.0), getattr(Catalogue, verb)

    def writing(catalogue, *arguments, **named):
        gate.wait()
        return write(catalogue, *arguments, **named)

    monkeypatch.setattr(Catalogue, verb, writing)


def both(*acts):
    """Run two acts at once; what each gave, or the sentence it was refused with."""
    found = {}

    def run(number, act):
        try:
            found[number] = act()
        except Refused as refusal:
            found[number] = str(refusal)

    threads = [threading.Thread(target=run, args=pair) for pair in enumerate(acts)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    told = [one for one in found.values() if isinstance(one, str)]
    kept = [one for one in found.values() if not isinstance(one, str)]
    assert (len(told), len(kept)) == (1, 1), found
    assert "meanwhile" in told[0]
    assert "compare and save again" in told[0]
    return kept[0]


def test_a_plan(rooms, patient, monkeypatch):
    one, two = rooms
    plan = one.plans.current(patient)
    items = [PlanItem(exercise=name) for name in ("open_close", "pinch")]
    meet(monkeypatch, "add_version")
    kept = both(
        lambda: one.plans.change(ANNA, replace(plan, items=(items[0],), reason="from room 1")),
        lambda: two.plans.change(BERT, replace(plan, items=(items[1],), reason="from room 2")),
    )
    assert two.plans.current(patient) == kept
    assert len(one.plans.history(patient)) == 1


def test_a_clinical_record(rooms, patient, monkeypatch):
    one, two = rooms
    records = [ClinicalRecord(patient=patient, diagnosis="stroke", mas=mas, by="x") for mas in ("1", "2")]
    meet(monkeypatch, "add_clinical_record")
    kept = both(
        lambda: one.clinical.state(ANNA, records[0], since=0),
        lambda: two.clinical.state(BERT, records[1], since=0),
    )
    assert two.clinical.records(patient) == (kept,)


def test_limits_of_a_joint(rooms, patient, monkeypatch):
    one, two = rooms
    one.limits.set_torque(ANNA, patient, "index_pip", 0.12)
    meet(monkeypatch, "add_limit_changes")
    both(
        lambda: one.limits.set_torque(ANNA, patient, "index_pip", 0.1),
        lambda: two.limits.set_range(BERT, patient, "index_pip", 0.1, 0.9),
    )
    assert len(one.catalogue.limit_changes(patient, "exoskeleton")) in (2, 3)


def test_limits_follow_the_record_that_was_read(rooms, patient, monkeypatch):
    """Who raises a torque while somebody states that torques are halved is told to look again."""
    one, two = rooms
    add = Catalogue.add_limit_changes

    def overtaken(catalogue, changes, since=None):
        two.clinical.state(BERT, ClinicalRecord(patient=patient, diagnosis="stroke", insensate=True, by="x"))
        return add(catalogue, changes, since)

    with monkeypatch.context() as between:
        between.setattr(Catalogue, "add_limit_changes", overtaken)
        with pytest.raises(Refused, match=rf"clinical record of {patient} is changed by bert meanwhile"):
            one.limits.set_torque(ANNA, patient, "index_pip", 0.45, reason="strong hand")
    assert one.catalogue.limit_changes(patient, "exoskeleton") == ()


def test_a_version_that_was_read_long_ago_is_refused(rooms, patient):
    one, two = rooms
    read = one.limits.show(patient).version
    assert read == 0
    two.limits.set_torque(BERT, patient, "index_pip", 0.12)
    with pytest.raises(Refused, match="changed by bert meanwhile"):
        one.limits.set_torque(ANNA, patient, "index_pip", 0.1, since=read)
    now = one.limits.show(patient).version
    assert one.limits.set_torque(ANNA, patient, "index_pip", 0.1, since=now).version > now


def test_a_range_is_set_whole_or_not_at_all(rooms, patient):
    """Its second end names nobody who is known: the first one is not kept either."""
    one, _ = rooms
    ends = [
        LimitChange(patient=who, device="exoskeleton", joint="index_pip", limit=limit, value=0.3, by="anna")
        for who, limit in ((patient, RANGE_LOW), ("P-9999", RANGE_HIGH))
    ]
    with pytest.raises(Refused, match="P-9999"):
        one.catalogue.add_limit_changes(tuple(ends))
    assert one.catalogue.limit_changes(patient, "exoskeleton") == ()
    one.limits.set_range(ANNA, patient, "index_pip", 0.1, 0.9)
    set_to = one.catalogue.limit_changes(patient, "exoskeleton")
    assert {row.limit: row.value for row in set_to} == {RANGE_LOW: 0.1, RANGE_HIGH: 0.9}
