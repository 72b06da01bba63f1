"""Progress over files: what is left out and why, comparisons, and work in a process of its own."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.aside import aside
from rehab_app.services.reports import format_named
from sessions.catalogue import Setting, TherapySession
from sessions.reports.past import Past, past_to_json, past_version

UTC_NS = 1_700_000_000_000_000_000


def kept_session(clinic, number, patient, **changes):
    made = Past(
        **{
            "session_id": "x",
            "sha256": f"{number:064x}",
            "subject_id": patient,
            "utc_start_ns": UTC_NS + number,
            "side": "right",
            "exercise": "open_close",
            **changes,
        }
    )
    entered = clinic.catalogue.add_session(
        TherapySession(
            patient=patient,
            sha256=f"{number:064x}",
            path=f"sessions/{number}.mcap",
            mode="passive",
            started_utc_ns=UTC_NS + number,
        )
    )
    clinic.catalogue.keep_metrics(f"{number:064x}", past_version(), past_to_json(made))
    return entered.id


def added(clinic, name):
    return clinic.patients.add(
        CONSOLE, given_name=name, family_name="Lind", birth_date="1960-02-29", side="right"
    ).id


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("clinic")) as opened:
        yield opened


def test_sessions_that_do_not_belong_are_left_out_with_the_reason(clinic):
    patient = added(clinic, "Eva")
    kept_session(clinic, 1, patient)
    kept_session(clinic, 2, patient, subject_id="P-9999")
    kept_session(clinic, 3, patient, side="left")
    kept_session(clinic, 4, patient, sha256="f" * 64)
    kept_session(clinic, 5, patient, reason="without a repetition")
    found = clinic.progress.of_patient(patient)
    assert len(found.pasts) == 1
    said = " ".join(item.reason for item in found.left_out)
    for reason in ("of P-9999", "left hand", "not the one that was sealed", "without a repetition"):
        assert reason in said


def test_a_file_that_is_gone_is_a_reason_and_no_failure(clinic):
    patient = added(clinic, "Ida")
    clinic.catalogue.add_session(
        TherapySession(
            patient=patient, sha256="a" * 64, path="sessions/gone.mcap", mode="passive", started_utc_ns=UTC_NS
        )
    )
    found = clinic.progress.of_patient(patient)
    assert "no such file" in found.left_out[0].reason


def test_sessions_of_two_patients_are_not_compared(clinic):
    one = kept_session(clinic, 11, added(clinic, "Ada"))
    other = kept_session(clinic, 12, added(clinic, "Lea"))
    with pytest.raises(Refused, match="of two patients"):
        clinic.progress.comparison(one, other)
    with pytest.raises(Refused, match="with itself"):
        clinic.progress.comparison(one, one)


def test_a_comparison_puts_the_earlier_session_first(clinic):
    patient = added(clinic, "Mia")
    first, second = kept_session(clinic, 21, patient), kept_session(clinic, 22, patient)
    found = clinic.progress.comparison(second, first)
    assert [one.session_id for one in found.pasts] == [first, second]


def test_unknown_formats_are_refused(clinic):
    patient = added(clinic, "Zoe")
    kept_session(clinic, 31, patient)
    with pytest.raises(Refused, match="docx"):
        clinic.progress.write(clinic.progress.of_patient(patient), ["docx"], None, CONSOLE)
    with pytest.raises(Refused, match="docx"):
        format_named("docx")


def test_work_aside_answers_refuses_and_fails_in_sentences():
    assert aside(os.path.join, "a", "b") == "a/b"
    with pytest.raises(Refused, match="docx"):
        aside(format_named, "docx")
    with pytest.raises(Refused, match="its process ended"):
        aside(Path.read_bytes, Path("/nowhere/at/all"))


def test_the_set_ups_own_repeatability_is_the_bound(clinic):
    patient = added(clinic, "Ute")
    kept_session(clinic, 41, patient)
    row = (
        '[{"name": "range_of_motion", "subject": "index_pip", "source": "encoder", '
        '"sem": 0.03, "mdc95": 0.096, "trials": 5}]'
    )
    clinic.catalogue.set(Setting(key="repeatability", content=row, by="console"))
    assert clinic.progress.of_patient(patient).bounds == (("range_of_motion", "index_pip", "encoder", 0.096),)
