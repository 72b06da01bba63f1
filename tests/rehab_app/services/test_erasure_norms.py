"""Norms forget with the patient: what was made with an erased one is cited no more."""

from __future__ import annotations

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.population import FEWEST
from tests.rehab_app.services.test_population import added, kept_session


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path) as opened:
        yield opened


def test_norms_made_with_an_erased_patient_hold_no_more(clinic):
    pasts = [kept_session(clinic, number, added(clinic)) for number in range(FEWEST + 1)]
    (before,) = clinic.norms.renew(CONSOLE)
    gone = clinic.patients.list()[-1].id
    clinic.privacy.erasures.erase(CONSOLE, gone, gone)
    assert clinic.norms.all() == ()
    assert clinic.norms.beside(pasts[0], "active") == ()
    (after,) = clinic.norms.renew(CONSOLE)
    assert (before.count, after.count) == (FEWEST + 1, FEWEST)
    assert after.high < before.high


def test_erasing_where_no_norms_were_made_writes_none(clinic):
    one = added(clinic)
    clinic.privacy.erasures.erase(CONSOLE, one, one)
    assert clinic.norms.all() == ()
    assert clinic.catalogue.setting("population-norms") is None
