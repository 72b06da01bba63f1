"""Limits of a patient: measured or shipped, narrowed by anyone, raised by a therapist, for a day."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.clinical import Clinical
from rehab_app.services.clock import day_end_ns, day_start_ns, local_day
from rehab_app.services.diagnosis import precautions
from rehab_app.services.limit_acts import LimitActs
from rehab_app.services.limits_json import limits_from_json, limits_to_json
from rehab_app.services.patient_limits import PatientLimits
from robot_iface.build import capabilities
from robot_iface.safety import shipped_limits
from robot_iface.types import Hull
from sessions.catalogue import Catalogue, ClinicalRecord, Patient

THERAPIST = Account("anna", "therapist", "1")
ASSISTANT = Account("bert", "assistant", "2")
DEVICE = capabilities("exoskeleton")
PIP = DEVICE.joint_names.index("index_pip")
NOON_NS = day_start_ns(1_790_000_000_000_000_000) + 12 * 3600 * 10**9
DAY_NS = 24 * 3600 * 10**9
WRIST = np.deg2rad(20.0)


class Room:
    """A catalogue with one patient, and a clock that is set by hand."""

    def __init__(self, folder):
        self.now_ns = NOON_NS
        self.catalogue = Catalogue.open(folder, clock_ns=lambda: self.now_ns)
        self.patient = self.catalogue.add_patient(Patient(side="left"))
        audit = Audit(self.catalogue)
        clinical = Clinical(self.catalogue, audit, lambda: self.now_ns)
        self.limits = PatientLimits(self.catalogue, audit, lambda: self.now_ns)
        self.acts = LimitActs(self.catalogue, clinical, self.limits)
        self.clinical = clinical

    def state(self, **changes):
        plain = ClinicalRecord(patient="P-0001", diagnosis="none", by="anna")
        return self.clinical.state(THERAPIST, replace(plain, **changes))

    def measure(self, **changes):
        low, high = DEVICE.q_min_rad + 0.3, DEVICE.q_max_rad - 0.4
        found = shipped_limits(DEVICE.joint_names, low, high)
        return self.limits.keep(CONSOLE, self.patient, DEVICE, replace(found, **changes), WRIST)

    def today(self, wrist_rad=WRIST):
        return self.limits.today(self.patient, DEVICE, wrist_rad, precautions(self.clinical.record("P-0001")))


@pytest.fixture
def room(tmp_path):
    made = Room(tmp_path)
    yield made
    made.catalogue.close()


def test_json_keeps_every_bit():
    hull = Hull(("index_mcp_flexion", "index_pip"), np.array([[0.1, 0.2], [1.0 / 3.0, 0.2], [0.3, 0.9]]))
    limits = shipped_limits(DEVICE.joint_names, DEVICE.q_min_rad, DEVICE.q_max_rad)
    for whole in (limits, replace(limits, hulls=(hull,), measured_utc_ns=7, expires_utc_ns=9, wrist_rad=0.1)):
        again = limits_from_json(limits_to_json(whole))
        assert limits_to_json(again) == limits_to_json(whole)
        assert np.array_equal(again.q_min_rad, whole.q_min_rad)
        assert np.array_equal(again.wrist_rad, whole.wrist_rad, equal_nan=True)
        assert [one.joints for one in again.hulls] == [one.joints for one in whole.hulls]


@pytest.mark.parametrize("text", ["", "[]", "{}", "hello", '{"q_min_rad": "x"}'])
def test_json_of_something_else_is_refused(text):
    with pytest.raises(Refused, match="stored limits"):
        limits_from_json(text)


def test_json_with_an_infinite_limit_is_refused():
    limits = shipped_limits(DEVICE.joint_names, DEVICE.q_min_rad, DEVICE.q_max_rad)
    endless = replace(limits, tau_interaction_nm=np.full(len(DEVICE.joint_names), np.inf))
    with pytest.raises(Refused, match="stored limits"):
        limits_from_json(limits_to_json(endless))


def test_a_day_lasts_from_midnight_to_midnight():
    assert day_start_ns(NOON_NS) < NOON_NS < day_end_ns(NOON_NS)
    assert local_day(day_end_ns(NOON_NS) - 1) == local_day(NOON_NS)
    assert local_day(day_end_ns(NOON_NS)) > local_day(NOON_NS)


def test_without_a_measurement_the_shipped_defaults_hold_and_are_stated(room):
    today = room.today()
    assert not today.measured
    assert not today.own_range
    assert "shipped defaults" in today.notes[0]
    assert today.limits.q_min_rad[PIP] == 0.0
    assert today.limits.tau_interaction_nm[PIP] == pytest.approx(0.15)


def test_what_was_measured_narrows_the_range_for_the_rest_of_the_day(room):
    kept = room.measure()
    today = room.today()
    assert today.measured
    assert today.own_range
    assert "by console" in today.notes[0]
    assert today.limits.q_min_rad[PIP] == pytest.approx(max(DEVICE.q_min_rad[PIP] + 0.3, 0.0))
    assert today.limits.q_max_rad[PIP] == pytest.approx(DEVICE.q_max_rad[PIP] - 0.4)
    assert today.limits.expires_utc_ns == kept.expires_utc_ns == day_end_ns(NOON_NS)
    assert today.limits.wrist_rad == pytest.approx(WRIST)
    assert room.catalogue.audit()[0].verb == "measure limits"


def test_a_measurement_never_widens_what_ships_for_the_present_record(room):
    room.measure(q_min_rad=DEVICE.q_min_rad - 1.0, tau_interaction_nm=np.full(12, 0.4))
    room.state(insensate=True, diagnosis="stroke", mas="2")
    limits = room.today().limits
    base = shipped_limits(DEVICE.joint_names, DEVICE.q_min_rad, DEVICE.q_max_rad, spastic=True, halved=True)
    assert np.all(limits.q_min_rad >= base.q_min_rad)
    assert np.allclose(limits.tau_interaction_nm, base.tau_interaction_nm)
    assert np.allclose(limits.extension_speed_rad_s, np.deg2rad(15.0))


def test_tomorrow_another_wrist_or_another_hand_is_refused_with_the_remedy(room):
    room.measure()
    room.today(WRIST + np.deg2rad(9.0))
    with pytest.raises(Refused, match="20 degrees, at which"):
        room.today(WRIST + np.deg2rad(11.0))
    room.catalogue.change_patient(replace(room.patient, side="right"))
    room.patient = room.catalogue.patient("P-0001")
    with pytest.raises(Refused, match="of the left hand"):
        room.today()
    room.now_ns = day_end_ns(NOON_NS)
    with pytest.raises(Refused, match=r"expired.*limits measure"):
        room.today()


def test_the_newest_measurement_at_this_wrist_angle_counts(room):
    room.measure()
    room.measure(q_max_rad=DEVICE.q_max_rad - 0.6)
    assert room.today().limits.q_max_rad[PIP] == pytest.approx(DEVICE.q_max_rad[PIP] - 0.6)


def test_a_therapist_raises_a_torque_for_today_up_to_the_cap(room):
    before = room.today(0.0).limits.tau_interaction_nm
    today = room.acts.set_torque(THERAPIST, "P-0001", "index_pip", 0.45, reason="stiff")
    assert today.limits.tau_interaction_nm[PIP] == pytest.approx(0.45)
    assert np.array_equal(np.delete(today.limits.tau_interaction_nm, PIP), np.delete(before, PIP))
    assert any("0.45 Nm by anna" in note for note in today.notes)
    row = room.catalogue.audit()[0]
    assert (row.actor, row.verb, row.subject) == ("anna", "set limit", "P-0001")
    room.now_ns += DAY_NS
    assert room.today(0.0).limits.tau_interaction_nm[PIP] == pytest.approx(0.15)


@pytest.mark.parametrize("value", [0.451, 0.0, -0.1, float("nan"), float("inf"), 0.019])
def test_no_torque_beyond_the_cap_or_of_no_use(room, value):
    with pytest.raises(Refused, match=r"0\.02 to 0\.45"):
        room.acts.set_torque(THERAPIST, "P-0001", "index_pip", value, reason="x")


def test_raising_needs_a_therapist_and_a_reason_and_a_joint(room):
    with pytest.raises(Refused, match="may not prescribe"):
        room.acts.set_torque(ASSISTANT, "P-0001", "index_pip", 0.2, reason="x")
    with pytest.raises(Refused, match="reason"):
        room.acts.set_torque(THERAPIST, "P-0001", "index_pip", 0.2, reason=" ")
    with pytest.raises(Refused, match="one of"):
        room.acts.set_torque(THERAPIST, "P-0001", "index_toe", 0.1)
    with pytest.raises(Refused, match="P-9999"):
        room.acts.set_torque(THERAPIST, "P-9999", "index_pip", 0.1)
    assert room.catalogue.limit_changes("P-0001", "exoskeleton") == ()


def test_anyone_lowers_a_torque_and_it_stays_lower(room):
    room.acts.set_torque(ASSISTANT, "P-0001", "index_pip", 0.1)
    room.acts.set_torque(THERAPIST, "P-0001", "index_pip", 0.3, reason="stiff today")
    assert room.today(0.0).limits.tau_interaction_nm[PIP] == pytest.approx(0.3)
    room.now_ns += DAY_NS
    assert room.today(0.0).limits.tau_interaction_nm[PIP] == pytest.approx(0.1)
    with pytest.raises(Refused, match="may not prescribe"):
        room.acts.set_torque(ASSISTANT, "P-0001", "index_pip", 0.12)


def test_halved_torques_stay_halved(room):
    room.acts.set_torque(THERAPIST, "P-0001", "index_pip", 0.14, reason="fine")
    room.state(insensate=True)
    assert room.today(0.0).limits.tau_interaction_nm[PIP] == pytest.approx(0.075)
    with pytest.raises(Refused, match=r"0\.225 Nm \(halved"):
        room.acts.set_torque(THERAPIST, "P-0001", "index_pip", 0.3, reason="x")


def test_a_raise_ends_when_the_clinical_record_is_stated_anew(room):
    """A torque that was raised for skin that feels is not meant for skin that does not."""
    room.acts.set_torque(THERAPIST, "P-0001", "index_pip", 0.4, reason="stiff")
    assert room.today(0.0).limits.tau_interaction_nm[PIP] == pytest.approx(0.4)
    room.now_ns += 10**9
    room.state(insensate=True)
    assert room.today(0.0).limits.tau_interaction_nm[PIP] == pytest.approx(0.075)
    room.now_ns += 10**9
    room.acts.set_torque(THERAPIST, "P-0001", "index_pip", 0.1, reason="looked at it")
    assert room.today(0.0).limits.tau_interaction_nm[PIP] == pytest.approx(0.1)


def test_anyone_narrows_a_range_and_only_a_therapist_widens_it(room):
    low, high = np.deg2rad(20.0), np.deg2rad(60.0)
    today = room.acts.set_range(ASSISTANT, "P-0001", "index_pip", low, high)
    assert (today.limits.q_min_rad[PIP], today.limits.q_max_rad[PIP]) == (low, high)
    assert today.own_range
    assert not today.measured
    room.now_ns += DAY_NS
    later = room.today(0.0)
    assert (later.limits.q_min_rad[PIP], later.limits.q_max_rad[PIP]) == (low, high)
    assert not later.own_range
    with pytest.raises(Refused, match="may not prescribe"):
        room.acts.set_range(ASSISTANT, "P-0001", "index_pip", low, np.deg2rad(70.0))
    room.acts.set_range(THERAPIST, "P-0001", "index_pip", low, np.deg2rad(70.0), reason="better")
    assert room.today(0.0).limits.q_max_rad[PIP] == pytest.approx(np.deg2rad(70.0))


@pytest.mark.parametrize(("low", "high"), [(-3.0, 60.0), (20.0, 120.0), (60.0, 20.0), (float("nan"), 60.0)])
def test_no_range_beyond_the_base_or_that_does_not_open(room, low, high):
    with pytest.raises(Refused, match="range of index_pip"):
        room.acts.set_range(THERAPIST, "P-0001", "index_pip", np.deg2rad(low), np.deg2rad(high), reason="x")


def test_a_range_that_no_movement_fits_into_is_refused(room):
    with pytest.raises(Refused, match=r"20 to 20.1 degrees.*5 degrees or wider"):
        room.acts.set_range(THERAPIST, "P-0001", "index_pip", np.deg2rad(20.0), np.deg2rad(20.1))
    today = room.acts.set_range(THERAPIST, "P-0001", "index_pip", np.deg2rad(20.0), np.deg2rad(25.0))
    assert np.isclose(today.limits.q_max_rad[PIP] - today.limits.q_min_rad[PIP], np.deg2rad(5.0))


def test_a_range_that_a_measurement_closes_is_refused_instead_of_turned_round(room):
    room.acts.set_range(ASSISTANT, "P-0001", "index_pip", np.deg2rad(70.0), np.deg2rad(100.0))
    room.measure(q_max_rad=np.full(12, np.deg2rad(50.0)))
    with pytest.raises(Refused, match="limits range"):
        room.today()
