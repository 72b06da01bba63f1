"""The page of assessments: what was found, what was the device's end, and what to do where nothing is."""

from __future__ import annotations

import math

import msgspec

from rehab_app.services.protocol_results import JointRange, JointTone, ProtocolResult
from sessions.catalogue import PatientEntry


def keep(clinic, patient, result):
    content = msgspec.json.encode(result).decode()
    clinic.catalogue.add_entry(
        PatientEntry(patient=patient, kind="assessment", topic=result.protocol, content=content, by="anna")
    )


def joint(alone, led, at_end=False):
    low, high = (math.radians(value) for value in alone)
    least, most = (math.radians(value) for value in led)
    return JointRange(
        joint="index_pip",
        active_min_rad=low,
        active_max_rad=high,
        passive_min_rad=least,
        passive_max_rad=most,
        extension_lag_rad=low - least,
        extension_deficit_rad=least,
        flexion_lag_rad=None,
        min_at_device_end=False,
        max_at_device_end=at_end,
    )


def test_it_says_what_to_do_before_anything_was_assessed(browser, patient):
    page = browser("therapist").get(f"/patients/{patient}/assessments").text
    assert "No range was assessed yet" in page
    assert f"/live?patient={patient}#assess" in page


def test_results_stand_with_the_first_beside_the_last(browser, clinic, patient):
    known = {"session": "abcd1234", "device": "exoskeleton", "side": "left", "wrist_rad": 0.0}
    for rows in ((joint((25, 60), (15, 70)),), (joint((20, 70), (11, 88), at_end=True),)):
        keep(clinic, patient, ProtocolResult(protocol="range", ranges=rows, **known))
    tone = JointTone(
        joint="index_pip",
        reached_rad_s=(0.17, None),
        resistance_nm=(0.05, None),
        catch_rad=(None, None),
        per_speed_nms_rad=0.033,
        interval_nms_rad=(0.026, 0.04),
    )
    notes = ("This is no Modified Ashworth grade: a device measured it, no hand.",)
    keep(
        clinic,
        patient,
        ProtocolResult(protocol="tone", tones=(tone,), arm_posture="<b>seated</b>", notes=notes, **known),
    )
    page = browser("assistant").get(f"/patients/{patient}/assessments").text
    assert "20 to 70" in page
    assert "11 to ≥ 88" in page
    assert "25 to 60" in page
    assert "0.033 (0.026 to 0.040)" in page
    assert "&lt;b&gt;seated" in page
    assert "no Modified Ashworth grade" in page
    assert browser("patient").get(f"/patients/{patient}/assessments").status_code == 403
