"""What a catalogue keeps of patients' hands: versions, newest first, none changed."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from sessions.catalogue import (
    AssistanceMemory,
    Catalogue,
    ClinicalRecord,
    DayLimits,
    FitCheck,
    LimitChange,
    ModeUnlock,
    Patient,
    PrescriptionRow,
    Take,
    TherapySession,
)
from sessions.errors import Refused

URLS: dict[str, Callable[[Path], str]] = {"sqlite": lambda folder: f"sqlite:///{folder / 'clinic.sqlite3'}"}
DAY_NS = 86_400_000_000_000


def sha(word: str) -> str:
    return hashlib.sha256(word.encode()).hexdigest()


@pytest.fixture(params=sorted(URLS))
def catalogue(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Catalogue]:
    clock = itertools.count(1_790_000_000_000_000_000, 1000)
    with Catalogue.open(tmp_path, URLS[request.param](tmp_path), lambda: next(clock)) as opened:
        opened.add_patient(Patient(side="left"))
        opened.add_patient(Patient(side="right"))
        yield opened


def record(**changes: object) -> ClinicalRecord:
    plain = ClinicalRecord(
        patient="P-0001", diagnosis="stroke", event_date="2026-03-01", mas="1+", insensate=True, by="anna"
    )
    return replace(plain, **changes)


def limits(**changes: object) -> DayLimits:
    plain = DayLimits(
        patient="P-0001",
        side="left",
        device="exoskeleton",
        wrist_rad=0.2,
        content='{"q_min_rad": [0.0]}',
        measured_utc_ns=10,
        expires_utc_ns=10 + DAY_NS,
        by="anna",
    )
    return replace(plain, **changes)


def test_records_are_versions_and_the_newest_is_first(catalogue: Catalogue) -> None:
    assert catalogue.clinical_records("P-0001") == ()
    first = catalogue.add_clinical_record(record())
    second = catalogue.add_clinical_record(record(mas="3", unaware=True, crps=True, bones_m="[]"))
    other = catalogue.add_clinical_record(record(patient="P-0002", rheumatoid=True))
    assert catalogue.clinical_records("P-0001") == (second, first)
    assert catalogue.clinical_records("P-0002") == (other,)
    assert first == record(id=first.id, created_utc_ns=first.created_utc_ns)
    assert first.created_utc_ns < second.created_utc_ns
    for wrong in (record(patient="P-9999"),):
        with pytest.raises(Refused, match="unknown"):
            catalogue.add_clinical_record(wrong)
    with pytest.raises(Refused, match="unknown"):
        catalogue.clinical_records("P-9999")


@pytest.mark.parametrize("bad", [{"mas": "5"}, {"mas": "1++"}, {"event_date": "1.3.2026"}, {"by": " "}])
def test_a_record_that_cannot_be_is_refused(bad: dict[str, object]) -> None:
    with pytest.raises(Refused):
        record(**bad)


def test_unlocks_name_who_why_and_for_what(catalogue: Catalogue) -> None:
    given = ModeUnlock(
        patient="P-0001",
        mode="passive",
        diagnosis="fracture",
        event_date="2026-03-01",
        unlocked=True,
        reason="plate is stable",
        by="anna",
    )
    first = catalogue.add_mode_unlock(given)
    taken_back = catalogue.add_mode_unlock(replace(given, unlocked=False, reason="", by="bert"))
    assert catalogue.mode_unlocks("P-0001") == (taken_back, first)
    assert catalogue.mode_unlocks("P-0002") == ()
    with pytest.raises(Refused, match="reason"):
        replace(given, reason=" ")
    with pytest.raises(Refused, match="nobody"):
        replace(given, by="")


def test_limits_of_a_day_belong_to_one_patient_and_device(catalogue: Catalogue) -> None:
    first = catalogue.add_day_limits(limits())
    second = catalogue.add_day_limits(limits(wrist_rad=-0.3, measured_utc_ns=20))
    catalogue.add_day_limits(limits(device="other"))
    catalogue.add_day_limits(limits(patient="P-0002", side="right"))
    assert catalogue.day_limits("P-0001", "exoskeleton") == (second, first)
    for bad in (
        {"side": "up"},
        {"wrist_rad": float("nan")},
        {"measured_utc_ns": 0},
        {"expires_utc_ns": 10},
        {"by": ""},
    ):
        with pytest.raises(Refused):
            limits(**bad)


def test_changes_of_single_limits_are_kept_in_order(catalogue: Catalogue) -> None:
    change = LimitChange(
        patient="P-0001",
        device="exoskeleton",
        joint="index_pip",
        limit="tau_interaction_nm",
        value=0.3,
        expires_utc_ns=99,
        reason="tight",
        by="anna",
    )
    first = catalogue.add_limit_change(change)
    second = catalogue.add_limit_change(replace(change, value=0.1, expires_utc_ns=0))
    assert catalogue.limit_changes("P-0001", "exoskeleton") == (second, first)
    assert catalogue.limit_changes("P-0001", "other") == ()
    for bad in ({"limit": "mood"}, {"value": float("inf")}, {"by": ""}):
        with pytest.raises(Refused):
            replace(change, **bad)


def test_assistance_is_remembered_by_patient_exercise_and_device(catalogue: Catalogue) -> None:
    run = catalogue.add_session(
        TherapySession(
            patient="P-0001", sha256=sha("run"), path="s/run.mcap", mode="assistive", started_utc_ns=1
        )
    )
    assert run.take == ""
    assert catalogue.session(run.id) == run
    given = AssistanceMemory(
        patient="P-0001",
        exercise="fist",
        device="exoskeleton",
        content="[[1,1,1,1,1],[2,2,2,2,2]]",
        session=run.id,
    )
    catalogue.add_assistance(given)
    last = catalogue.add_assistance(replace(given, content="[]"))
    assert catalogue.assistance("P-0001", "fist", "exoskeleton") == last
    assert catalogue.assistance("P-0001", "wave", "exoskeleton") is None
    assert catalogue.assistance("P-0001", "fist", "other") is None
    assert catalogue.assistance("P-0002", "fist", "exoskeleton") is None
    with pytest.raises(Refused, match="unknown"):
        catalogue.add_assistance(replace(given, session="nothing"))


def test_fit_checks_are_kept_by_patient_and_device(catalogue: Catalogue) -> None:
    run = catalogue.add_session(
        TherapySession(
            patient="P-0001", sha256=sha("fit"), path="s/fit.mcap", mode="transparent", started_utc_ns=1
        )
    )
    given = FitCheck(
        patient="P-0001",
        side="left",
        device="exoskeleton",
        content="{}",
        verdict="",
        session=run.id,
        by="anna",
    )
    first = catalogue.add_fit_check(given)
    second = catalogue.add_fit_check(replace(given, verdict="index_pip sticks"))
    assert catalogue.fit_checks("P-0001", "exoskeleton") == (second, first)
    assert catalogue.fit_checks("P-0002", "exoskeleton") == catalogue.fit_checks("P-0001", "other") == ()
    with pytest.raises(Refused, match="unknown"):
        catalogue.add_fit_check(replace(given, session="nothing"))
    for bad in ({"side": "up"}, {"by": ""}):
        with pytest.raises(Refused):
            replace(given, **bad)


def test_a_retouched_take_and_a_whole_prescription_keep_their_authors(catalogue: Catalogue) -> None:
    plain = Take(
        sha256=sha("a"),
        path="takes/a.mcap",
        side="left",
        exercise="fist",
        source="camera",
        duration_s=9.0,
        subject_id="T-1",
    )
    parent = catalogue.add_take(plain)
    child = catalogue.add_take(
        replace(
            plain,
            sha256=sha("b"),
            path="takes/b.mcap",
            parent=parent.id,
            author="anna",
            reason="too fast",
            retouch='{"slow": 0.5}',
        )
    )
    assert catalogue.take(child.id) == child
    assert (child.parent, child.author, child.reason) == (parent.id, "anna", "too fast")
    ordered = catalogue.add_prescription(
        PrescriptionRow(
            patient="P-0001",
            take=child.id,
            mode="passive",
            speed=0.5,
            repetitions=3,
            stiffness_multiple=3.0,
            content='{"space": "fingertip"}',
            by="anna",
        )
    )
    assert catalogue.prescriptions("P-0001") == (ordered,)
    assert (ordered.content, ordered.by) == ('{"space": "fingertip"}', "anna")
