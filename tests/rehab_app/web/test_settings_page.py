"""What holds for the whole clinic: each setting is checked, audited, used, never lost to a second person."""

from __future__ import annotations

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.presentation import Presentation
from rehab_app.web import create_app
from sessions.catalogue import TherapySession
from sessions.catalogue.beginnings import Begun

from .conftest import PASSWORD, Browser, NoPictures

NOW = {"name": "", "language": "", "idle": "10", "retention": "10", "aim": "70"}


@pytest.fixture
def own(tmp_path):
    with open_clinic(tmp_path) as opened:
        opened.accounts.set_up("ada", PASSWORD)
        opened.accounts.sign_ins.set_idle_s(600, "ada")
        yield opened


@pytest.fixture
def app(own):
    return create_app(own, open_viewports=lambda _: NoPictures())


@pytest.fixture
def ada(app):
    return Browser(app, "ada")


def read(clinic):
    return {
        "name": clinic.presentation.name(),
        "language": clinic.presentation.language(),
        "idle": clinic.accounts.sign_ins.idle_s(),
        "retention": clinic.privacy.retention.years(),
        "aim": clinic.proposals.target(),
    }


@pytest.mark.parametrize(
    ("kind", "typed", "kept"),
    [
        ("name", "  Clinica <b>San Giovanni</b>  ", "Clinica <b>San Giovanni</b>"),
        ("name", "مستشفى", "مستشفى"),
        ("name", "x" * 120, "x" * 120),
        ("language", "it", "it"),
        ("idle", "5", 300),
        ("retention", "0", 0),
        ("aim", "62,5", 0.625),
        ("aim", "62.5", 0.625),
    ],
)
def test_a_setting_is_kept_shown_and_audited(own, ada, kind, typed, kept):
    answer = ada.post(f"/clinic/settings/{kind}", value=typed, was=NOW[kind])
    assert answer.status_code == 303
    assert read(own)[kind] == kept
    assert "<b>San" not in ada.get("/clinic/settings").text
    own.audit.close()
    assert next(iter(own.catalogue.audit())).actor == "ada"
    assert own.catalogue.verify_audit() > 0


@pytest.mark.parametrize(
    ("kind", "typed", "sentence"),
    [
        ("name", "x" * 10_000, "at most 120 characters"),
        ("name", "a\u202eb", "U+202E"),
        ("language", "de", "one of en, it"),
        ("idle", "61", "1 to 60 minutes"),
        ("idle", "", "a whole number"),
        ("idle", "1,5", "a whole number"),
        ("retention", "101", "0 (keep) to 100 years"),
        ("retention", "ten", "a whole number"),
        ("aim", "95", "50 to 90 %"),
        ("aim", "nan", "a number of percent"),
        ("aim", "", "a number of percent"),
    ],
)
def test_what_is_refused_stands_beside_its_field_with_what_was_typed(own, ada, kind, typed, sentence):
    before = read(own)
    answer = ada.post(f"/clinic/settings/{kind}", value=typed, was=NOW[kind])
    assert answer.status_code == 409
    assert sentence in answer.text
    assert f'id="{kind}-problem"' in answer.text
    assert kind == "language" or f'value="{typed}"' in answer.text
    assert read(own) == before


def test_the_second_of_two_people_is_told_and_neither_value_is_lost(own, ada):
    assert ada.post("/clinic/settings/name", value="North", was="").status_code == 303
    late = ada.post("/clinic/settings/name", value="South", was="")
    assert late.status_code == 409
    assert "changed to &#39;North&#39; by somebody else" in late.text
    assert 'value="South"' in late.text
    assert own.presentation.name() == "North"
    assert ada.post("/clinic/settings/name", value="South", was="North").status_code == 303
    assert own.presentation.name() == "South"


def test_the_language_is_the_clinics_until_somebody_chooses(own, app, ada):
    ada.post("/clinic/settings/language", value="it", was="")
    assert 'lang="it"' in Browser(app).get("/sign-in").text
    assert '<html lang="it">' in Browser(app).get("/sign-in", **{"accept-language": "en"}).text
    visitor = Browser(app)
    visitor.post("/language", language="en", back="/sign-in")
    assert '<html lang="en">' in visitor.get("/sign-in").text
    ada.post("/clinic/settings/language", value="", was="it")
    assert '<html lang="en">' in Browser(app).get("/sign-in").text


def test_another_station_learns_of_it_within_seconds(own):
    now = [0]
    here = Presentation(own.catalogue, own.audit, lambda: now[0])
    assert here.language() == ""
    own.presentation.set_language(CONSOLE, "it", ("en", "it"))
    now[0] += 9_000_000_000
    assert here.language() == ""
    now[0] += 2_000_000_000
    assert here.language() == here.usual_language == "it"


def test_nobody_but_an_administrator_changes_them(own):
    own.accounts.add_user("tom", "therapist", PASSWORD, CONSOLE)
    tom = own.accounts.account("tom")
    with pytest.raises(Refused):
        own.presentation.set_name(tom, "Tom's")
    with pytest.raises(Refused):
        own.presentation.set_language(tom, "it", ("en", "it"))


def test_a_new_clinic_shows_its_first_steps_until_each_is_done(own, ada):
    def shown():
        pages = [ada.get(path).text for path in ("/live", "/patients", "/clinic")]
        return {page.count('class="first-steps"') for page in pages}, pages[1]

    counts, page = shown()
    assert counts == {1}
    assert all(f'href="{path}"' in page for path in ("/patients/new", "/live#record"))
    own.patients.add(CONSOLE, given_name="A", family_name="B", birth_date="1950-12-31", side="left")
    assert "✓ Add a patient" in shown()[1]
    take = own.takes.record_virtual("open_close", "left", 1.5, 3, CONSOLE).take
    assert "✓ Record a movement" in shown()[1]
    assert own.catalogue.begun() == Begun(patients=True, takes=True, sessions=False)
    played = TherapySession(
        patient="P-0001", take=take, mode="passive", path="s.mcap", sha256="0" * 64, started_utc_ns=1
    )
    own.catalogue.add_session(played)
    assert shown()[0] == {0}


def test_who_does_none_of_the_first_steps_is_not_led(own, app):
    own.accounts.add_user("otto", "auditor", PASSWORD, CONSOLE)
    assert 'class="first-steps"' not in Browser(app, "otto").get("/patients").text


def test_the_clinics_name_stands_at_the_head_of_reports_that_people_read(own, ada):
    take = own.takes.record_virtual("open_close", "left", 1.5, 3, CONSOLE).take
    assert "Clinic" not in own.reports.rendered("note", take).decode()
    ada.post("/clinic/settings/name", value="North & <b>South</b>", was="")
    page = own.reports.html(take, language="it")
    assert "<dt>Clinica</dt><dd>North &amp; &lt;b&gt;South&lt;/b&gt;</dd>" in page
    for name in ("json", "csv", "fhir"):
        assert b"North" not in own.reports.rendered(name, take)
