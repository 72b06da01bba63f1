"""Norms: one value per patient, groups of one patient's kind, none that is anybody's."""

from __future__ import annotations

from dataclasses import replace
from datetime import date

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.population import FEWEST, Group, Sample, age_band, in_words, norms_of
from sessions.catalogue import TherapySession
from sessions.reports.past import Kept, Past, past_to_json, past_version

GROUP = Group("range_of_motion", "index_pip", "encoder", "passive", 60, "right", "stroke")
UTC_NS, DAY_NS = 1_700_000_000_000_000_000, 86_400_000_000_000


def samples(values, group=GROUP, day=0):
    return [
        Sample(group, f"P-{number:04d}", UTC_NS + day * DAY_NS, value) for number, value in enumerate(values)
    ]


def test_the_spread_is_that_of_the_values():
    values = np.random.default_rng(4).normal(1.0, 0.2, 40)
    (norm,) = norms_of(samples(values))
    assert norm.count == 40
    assert norm.mean == pytest.approx(values.mean())
    assert norm.sd == pytest.approx(values.std(ddof=1))
    assert (norm.low, norm.median, norm.high) == pytest.approx(tuple(np.percentile(values, (5, 50, 95))))


def test_the_order_does_not_matter():
    rng = np.random.default_rng(5)
    given = samples(rng.normal(1.0, 0.2, 20)) + samples(rng.normal(2.0, 0.2, 20), replace(GROUP, age_from=70))
    expected = norms_of(given)
    for _ in range(5):
        rng.shuffle(given)
        assert norms_of(given) == expected


def test_a_patient_counts_once_with_the_first_session():
    first = samples([1.0] * FEWEST)
    assert norms_of(first + samples([9.0] * FEWEST, day=3)) == norms_of(first)


def test_a_small_group_is_not_told():
    assert norms_of(samples([1.0] * (FEWEST - 1))) == ()
    assert norms_of(samples([1.0] * (FEWEST - 1)) + samples([1.0] * (FEWEST - 1), day=1)) == ()


@pytest.mark.parametrize(
    ("birth", "day", "band"),
    [
        ("1960-02-29", date(2020, 2, 28), 50),
        ("1960-02-29", date(2020, 2, 29), 60),
        ("1960-02-29", date(2030, 2, 28), 60),
        ("2020-01-01", date(2020, 1, 1), 0),
        ("2020-01-02", date(2020, 1, 1), None),
        ("", date(2020, 1, 1), None),
    ],
)
def test_decades_of_age(birth, day, band):
    assert age_band(birth, day) == band


def test_it_is_cited_with_its_size():
    (norm,) = norms_of(samples([1.0] * 12))
    assert in_words(norm) == "n = 12, this clinic, age 60-69"


def kept_session(clinic, number, patient, **changes):
    made = Past(
        "x",
        f"{number:064x}",
        patient,
        UTC_NS,
        "right",
        "open_close",
        numbers=(
            Kept("range_of_motion", "index_pip", 1.0 + number / 10, None, None, "ok", "1", "encoder"),
            Kept("range_of_motion", "index_dip", 1.0, None, None, "flagged: short", "1", "encoder"),
            Kept("range_of_motion", "thumb_ip", None, None, None, "not measurable: still", "1", "encoder"),
        ),
    )
    clinic.catalogue.add_session(
        TherapySession(
            patient=patient,
            sha256=f"{number:064x}",
            path=f"sessions/{number}.mcap",
            mode="active",
            started_utc_ns=UTC_NS,
        )
    )
    made = replace(made, **changes)
    clinic.catalogue.keep_metrics(f"{number:064x}", past_version(), past_to_json(made))
    return made


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path) as opened:
        yield opened


def added(clinic, birth="1960-02-29"):
    return clinic.patients.add(
        CONSOLE, given_name="Eva", family_name="Lind", birth_date=birth, side="right"
    ).id


def test_norms_of_a_clinic_are_kept_and_found_again(clinic):
    pasts = [kept_session(clinic, number, added(clinic)) for number in range(FEWEST)]
    (norm,) = clinic.norms.renew(CONSOLE)
    assert norm.group == Group("range_of_motion", "index_pip", "encoder", "active", 60, "right", "")
    assert norm.median == pytest.approx(1.2)
    assert clinic.norms.all() == (norm,)
    assert clinic.norms.beside(pasts[0], "active") == (norm,)
    assert clinic.norms.beside(pasts[0], "passive") == ()


def test_who_cannot_be_placed_takes_no_part(clinic):
    for number in range(FEWEST - 1):
        kept_session(clinic, number, added(clinic))
    kept_session(clinic, 20, added(clinic, ""))
    kept_session(clinic, 21, added(clinic), subject_id="P-9999")
    kept_session(clinic, 22, added(clinic), reason="without a repetition")
    kept_session(clinic, 23, added(clinic), sha256="f" * 64)
    assert clinic.norms.renew(CONSOLE) == ()
    kept_session(clinic, 24, added(clinic))
    assert len(clinic.norms.renew(CONSOLE)) == 1


def test_norms_of_another_version_are_not_cited(clinic, monkeypatch):
    for number in range(FEWEST):
        kept_session(clinic, number, added(clinic))
    clinic.norms.renew(CONSOLE)
    monkeypatch.setattr("rehab_app.services.population_norms.past_version", lambda: "past-of-tomorrow")
    assert clinic.norms.all() == ()


def test_an_assistant_may_not_make_them(clinic):
    assert clinic.norms.all() == ()
    with pytest.raises(Refused, match="assistant"):
        clinic.norms.renew(Account("kim", "assistant", "2"))
