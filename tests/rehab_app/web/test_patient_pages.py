"""A patient's pages: forms that come back with what was typed, two people at one record, roles."""

from __future__ import annotations

import hashlib
import html
import re
import time

import pytest

from rehab_app.access import CONSOLE, ROLES, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.services.limits_json import limits_to_json
from rehab_app.services.plan_items import Plan, PlanItem
from rehab_app.web import create_app
from sessions.catalogue import DayLimits, Take, TherapySession

from .conftest import ATTACK, PASSWORD, NoPictures

FORM = {
    "given_name": "Eva",
    "family_name": "Lind",
    "birth_date": "1960-02-29",
    "side": "right",
    "hand_length_cm": "17,5",
    "impairment": "",
}
TABS = ("", "/edit", "/diagnosis", "/limits", "/outcomes", "/journal", "/sessions")
DAY_NS = 86_400_000_000_000
NOTE, PAIN, EVENT = "/journal/note", "/journal/pain", "/journal/event"


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    """A clinic of this module's own: its patients are counted."""
    with open_clinic(tmp_path_factory.mktemp("patients")) as opened:
        for role in ROLES:
            opened.accounts.add_user(role, role, PASSWORD, CONSOLE)
        yield opened


@pytest.fixture(scope="module")
def app(clinic):
    return create_app(clinic, open_viewports=lambda _: NoPictures())


@pytest.fixture
def at(clinic):
    """Path of a patient whom no other test has seen."""
    number = len(clinic.patients.list()) + len(clinic.patients.search(archived=True).patients)
    added = clinic.patients.add(
        CONSOLE,
        given_name="Ada",
        family_name=f"Case{number}",
        birth_date="1957-05-17",
        side="left",
        impairment="first words",
    )
    return f"/patients/{added.id}"


def text_of(answer):
    return html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", answer.text)))


def edit_form(at, clinic, **changed):
    """What a browser sends that opened the form now."""
    patient = clinic.patients.get(at.rsplit("/", 1)[1])
    fields = {
        "given_name": patient.given_name,
        "family_name": patient.family_name,
        "birth_date": patient.birth_date,
        "side": patient.side,
        "hand_length_cm": "18.9",
        "impairment": patient.impairment,
    }
    was = {f"was_{name}": value for name, value in fields.items()}
    return {"version": str(patient.version), **was, **fields, **changed}


@pytest.mark.parametrize("tail", TABS)
@pytest.mark.parametrize("role", ROLES)
def test_pages_ask_for_the_role_and_name_the_patient_completely(browser, at, tail, role):
    answer = browser(role).get(at + tail)
    may = Account(role, role, "1").may("prescribe" if tail == "/edit" else "view")
    assert answer.status_code == (200 if may else 403)
    if may:
        assert answer.text.count("<h1>") == 1
        assert "17 May 19" in answer.text
        assert "Left hand" in answer.text


@pytest.mark.parametrize("role", ROLES)
def test_verbs_ask_for_the_role(browser, at, role):
    verbs = {
        "/edit": "prescribe",
        "/archive": "prescribe",
        "/unarchive": "prescribe",
        "/diagnosis": "prescribe",
        "/unlock": "prescribe",
        "/lock": "view",
        "/outcomes": "note",
        NOTE: "note",
        PAIN: "note",
        EVENT: "note",
    }
    for tail, verb in verbs.items():
        assert (browser(role).post(at + tail).status_code != 403) == Account(role, role, "1").may(verb)
        assert browser().post(at + tail).headers["location"].startswith("/sign-in")


@pytest.mark.parametrize("tail", TABS)
def test_an_unknown_patient_is_a_sentence(browser, tail):
    answer = browser("therapist").get(f"/patients/P-9999{tail}")
    assert answer.status_code == 404
    assert "P-9999" in answer.text


def test_the_list_is_searched_sorted_and_shows_the_archived_on_demand(browser, clinic, at):
    visitor, named = browser("therapist"), clinic.patients.get(at.rsplit("/", 1)[1])
    assert f'href="{at}"' in visitor.get(f"/patients?find={named.family_name.upper()}").text
    assert "Nobody is found" in visitor.get("/patients?find=%3Cscript%3Eqqq").text
    assert "<script>qqq" not in visitor.get("/patients?find=%3Cscript%3Eqqq").text
    assert visitor.get("/patients?order=nonsense").status_code == 404
    assert visitor.get("/patients?page=99999999999").status_code == 200
    visitor.post(f"{at}/archive")
    assert f'href="{at}"' not in visitor.get("/patients").text
    assert f'href="{at}"' in visitor.get("/patients?archived=yes").text
    assert "Archived" in visitor.get(at).text
    visitor.post(f"{at}/unarchive")
    assert f'href="{at}"' in visitor.get("/patients").text


def test_somebody_like_a_patient_is_added_only_after_looking(browser, clinic, at):
    known = clinic.patients.get(at.rsplit("/", 1)[1])
    visitor, before = browser("therapist"), len(clinic.patients.list())
    twin = {**FORM, "given_name": "ADA", "family_name": known.family_name.lower(), "impairment": "typed text"}
    answer = visitor.post("/patients", **twin)
    assert answer.status_code == 409
    assert f'value="{known.id}"' in answer.text
    assert "typed text" in answer.text
    assert visitor.post("/patients", **twin, others="P-9999").status_code == 409
    assert len(clinic.patients.list()) == before
    assert visitor.post("/patients", **twin, others=known.id).status_code == 303
    assert len(clinic.patients.list()) == before + 1


def test_every_wrong_field_is_told_at_once_and_linked(browser, clinic):
    before = len(clinic.patients.list())
    wrong = {**FORM, "given_name": "a\u202eb", "birth_date": "", "hand_length_cm": "400", "side": "both"}
    answer = browser("therapist").post("/patients", **wrong)
    assert answer.status_code == 409
    for field in ("given_name", "birth_date", "hand_length_cm", "side"):
        assert f'href="#{field}"' in answer.text
        assert f'id="{field}-problem"' in answer.text
    assert "400 cm, but must be 10 to 26 cm" in answer.text
    assert len(clinic.patients.list()) == before


@pytest.mark.parametrize("field", ["given_name", "family_name", "impairment"])
def test_ten_thousand_characters_are_a_sentence_and_come_back(browser, clinic, at, field):
    long = "é" * 10_000
    answer = browser("therapist").post(f"{at}/edit", **edit_form(at, clinic, **{field: long}))
    assert answer.status_code == 409
    assert "10000 characters long" in answer.text
    assert long in answer.text


def test_of_two_who_edit_the_later_is_told_and_no_text_is_lost(browser, clinic, at):
    opened = edit_form(at, clinic)
    first, second = browser("therapist"), browser("administrator")
    theirs = {"impairment": "stiff ring finger", "given_name": "Augusta"}
    assert first.post(f"{at}/edit", **{**opened, **theirs}).status_code == 303
    answer = second.post(
        f"{at}/edit",
        **{**opened, "impairment": "weak pinch", "family_name": "Byron", "hand_length_cm": "400"},
    )
    assert answer.status_code == 409
    told = text_of(answer)
    assert "therapist saved this record while you were editing it" in told
    assert "weak pinch stiff ring finger yours: decide" in told
    assert "Augusta theirs, you had not changed it" in told
    assert 'name="family_name" value="Byron"' in answer.text
    assert 'name="given_name" value="Augusta"' in answer.text
    assert "400 cm, but must be" in told
    patient = clinic.patients.get(at.rsplit("/", 1)[1])
    assert (patient.impairment, patient.given_name) == ("stiff ring finger", "Augusta")
    decided = edit_form(at, clinic, family_name="Byron", impairment="stiff ring finger, weak pinch")
    assert second.post(f"{at}/edit", **decided).status_code == 303
    patient = clinic.patients.get(patient.id)
    assert (patient.given_name, patient.family_name) == ("Augusta", "Byron")
    assert patient.impairment == "stiff ring finger, weak pinch"


def test_what_only_one_changed_clashes_with_nobody(browser, clinic, at):
    opened = edit_form(at, clinic)
    visitor = browser("therapist")
    visitor.post(f"{at}/archive")
    visitor.post(f"{at}/unarchive")
    assert visitor.post(f"{at}/edit", **{**opened, "impairment": "new words"}).status_code == 303
    assert clinic.patients.get(at.rsplit("/", 1)[1]).impairment == "new words"


def test_without_a_version_nothing_is_overwritten(browser, clinic, at):
    sent = edit_form(at, clinic, impairment="new words")
    del sent["version"]
    sent = {name: value for name, value in sent.items() if not name.startswith("was_")}
    assert browser("therapist").post(f"{at}/edit", **sent).status_code == 409
    assert clinic.patients.get(at.rsplit("/", 1)[1]).impairment == "first words"


def test_the_record_is_stated_and_the_later_of_two_sees_both(browser, clinic, at):
    first, second = browser("therapist"), browser("administrator")
    assert "Nobody has stated a diagnosis" in first.get(at).text
    assert first.post(f"{at}/diagnosis", since="0", diagnosis="crps", mas="1+").status_code == 303
    answer = second.post(f"{at}/diagnosis", since="0", diagnosis="burn", insensate="yes")
    assert answer.status_code == 409
    told = text_of(answer)
    assert "therapist stated version" in told
    assert "Burn or contracture of the skin Complex regional pain syndrome" in told
    record = clinic.clinical.record(at.rsplit("/", 1)[1])
    assert record.diagnosis == "crps"
    assert f'name="since" value="{record.id}"' in answer.text
    assert "checked> The skin does not feel" in answer.text
    assert second.post(f"{at}/diagnosis", since=str(record.id), diagnosis="burn").status_code == 303


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"diagnosis": ""}, "diagnosis"),
        ({"diagnosis": "flu"}, "diagnosis"),
        ({"event_date": "2999-01-01"}, "event_date"),
        ({"event_date": "soon"}, "event_date"),
        ({"mas": "9"}, "mas"),
        ({"thumb_1": "45"}, "index_2"),
        ({"thumb_1": "4500"}, "thumb_1"),
    ],
)
def test_a_wrong_record_is_refused_beside_its_field(browser, clinic, at, fields, field):
    answer = browser("therapist").post(f"{at}/diagnosis", **{"since": "0", "diagnosis": "stroke", **fields})
    assert answer.status_code == 409
    assert f'href="#{field}"' in answer.text
    assert clinic.clinical.record(at.rsplit("/", 1)[1]) is None


def test_bones_are_kept_in_metres_and_shown_in_millimetres(browser, clinic, at):
    bones = {
        f"{digit}_{n}": "25,5" for digit in ("thumb", "index", "middle", "ring", "little") for n in (1, 2, 3)
    }
    visitor = browser("therapist")
    assert visitor.post(f"{at}/diagnosis", since="0", diagnosis="none", **bones).status_code == 303
    assert "0.0255" in clinic.clinical.record(at.rsplit("/", 1)[1]).bones_m
    assert (
        'name="ring_2" inputmode="decimal" aria-label="ring 2, mm" value="25.5"'
        in visitor.get(f"{at}/diagnosis").text
    )


def test_a_mode_is_unlocked_with_a_reason_and_locked_again(browser, clinic, at):
    therapist, assistant = browser("therapist"), browser("assistant")
    therapist.post(f"{at}/diagnosis", since="0", diagnosis="crps")
    answer = therapist.post(f"{at}/unlock", mode="passive", reason="")
    assert answer.status_code == 409
    assert 'id="reason_passive-problem"' in answer.text
    long = therapist.post(f"{at}/unlock", mode="passive", reason="y" * 501)
    assert "y" * 501 in long.text
    assert assistant.post(f"{at}/unlock", mode="passive", reason="x").status_code == 403
    assert therapist.post(f"{at}/unlock", mode="passive", reason=ATTACK).status_code == 303
    assert ATTACK not in therapist.get(at).text
    assert "Unlocked by therapist" in therapist.get(at).text
    assert assistant.post(f"{at}/lock", mode="passive").status_code == 303
    assert set(clinic.clinical.locks(at.rsplit("/", 1)[1])) == {"passive", "resistive"}


def test_the_journal_is_written_corrected_and_escaped(browser, clinic, at):
    visitor = browser("assistant")
    assert visitor.post(at + NOTE, text=ATTACK).status_code == 303
    assert visitor.post(at + PAIN, score="7", place="thumb", when="during").status_code == 303
    assert visitor.post(at + EVENT, severity="mild", happened="red skin", done="pad").status_code == 303
    shown = visitor.get(f"{at}/journal").text
    assert ATTACK not in shown
    assert "Pain 7 of 10" in shown
    assert "<circle" in shown
    event, pain, _ = clinic.journal.entries(at.rsplit("/", 1)[1])
    assert "red skin" in visitor.get(f"{at}/journal?corrects={event.id}").text
    corrected = visitor.post(at + PAIN, score="3", corrects=str(pain.id))
    assert corrected.status_code == 303
    assert f"corrects {pain.id}" in visitor.get(f"{at}/journal").text
    again = visitor.post(at + PAIN, score="4", place="palm", corrects=str(pain.id))
    assert again.status_code == 409
    assert 'value="palm"' in again.text
    quick = visitor.post(at + NOTE, text="quick", back="overview")
    assert quick.headers["location"] == at


@pytest.mark.parametrize(
    ("tail", "fields", "field", "kept"),
    [
        (NOTE, {"text": "x" * 4001}, "text", "x" * 4001),
        (NOTE, {"text": ""}, "text", ""),
        (PAIN, {"score": "", "place": "wrist joint"}, "score", "wrist joint"),
        (PAIN, {"score": "11", "remark": "odd"}, "score", "odd"),
        (PAIN, {"score": "1", "when": "never"}, "when", ""),
        (EVENT, {"severity": "", "happened": "strap", "done": "pad"}, "severity", "strap"),
        (EVENT, {"severity": "mild", "happened": "strap", "done": ""}, "done", "strap"),
    ],
)
def test_a_wrong_entry_comes_back_with_its_sentence(browser, clinic, at, tail, fields, field, kept):
    answer = browser("therapist").post(at + tail, **fields)
    assert answer.status_code == 409
    assert f'href="#{field}"' in answer.text
    assert kept in answer.text
    assert clinic.journal.entries(at.rsplit("/", 1)[1]) == ()


def test_outcomes_are_entered_compared_and_corrected(browser, clinic, at):
    visitor = browser("assistant")
    assert "None is entered yet" in visitor.get(f"{at}/outcomes").text
    for day, value in (("2026-01-01", "10"), ("2026-02-01", "30")):
        sent = {"measure": "arat", "value": value, "side": "left", "measured_on": day}
        assert visitor.post(f"{at}/outcomes", **sent).status_code == 303
    told = text_of(visitor.get(f"{at}/outcomes"))
    assert "+20 ▲ better" in told
    assert "6 to 17: large enough to matter" in told
    assert "30 (+20)" in told
    now = clinic.outcomes.list(at.rsplit("/", 1)[1])[0]
    form = visitor.get(f"{at}/outcomes?corrects={now.id}").text
    assert 'value="30"' in form
    fixed = {"measure": "arat", "value": "13", "side": "left", "measured_on": now.measured_on}
    assert visitor.post(f"{at}/outcomes", **fixed, corrects=str(now.id)).status_code == 303
    assert "+3 ▲ better" in text_of(visitor.get(f"{at}/outcomes"))


@pytest.mark.parametrize("key", ["mas", "pinch", "gas-t", "monofilament", "tardieu-r1", "nonsense"])
def test_the_form_follows_the_measure(browser, at, key):
    answer = browser("therapist").get(f"{at}/outcomes?measure={key}")
    assert answer.status_code == 200
    assert ('name="side"' in answer.text) == (key != "gas-t")
    assert ('name="place"' in answer.text) == (key in ("mas", "pinch", "monofilament", "tardieu-r1"))


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"measure": "iq"}, "measure"),
        ({"value": "58"}, "value"),
        ({"value": "twelve"}, "value"),
        ({"side": ""}, "side"),
        ({"measured_on": "2999-01-01"}, "measured_on"),
        ({"measure": "pinch", "place": "nose"}, "place"),
        ({"remark": "x" * 501}, "remark"),
    ],
)
def test_a_wrong_outcome_comes_back_beside_its_field(browser, clinic, at, fields, field):
    sent = {"measure": "arat", "value": "12", "side": "left", "remark": "seated", **fields}
    answer = browser("therapist").post(f"{at}/outcomes", **sent)
    assert answer.status_code == 409
    assert f'href="#{field}"' in answer.text
    assert sent["remark"] in answer.text
    assert clinic.outcomes.list(at.rsplit("/", 1)[1]) == ()


def test_the_overview_shows_the_plan(browser, clinic, at):
    item = PlanItem(exercise="open_close", mode="passive", repetitions=37)
    named = at.rsplit("/", 1)[1]
    assert "Nothing is prescribed yet." in browser("therapist").get(at).text
    clinic.plans.change(CONSOLE, Plan(patient=named, items=(item,), goal="button a shirt"))
    told = text_of(browser("assistant").get(at))
    assert "button a shirt" in told
    assert "37 ×" in told


@pytest.mark.parametrize("tail", TABS)
def test_pages_answer_in_every_language(browser, clinic, at, tail):
    visitor, named = browser("therapist"), at.rsplit("/", 1)[1]
    visitor.post(f"{at}/diagnosis", since="0", diagnosis="flexor-tendon-repair", event_date="2026-01-01")
    visitor.post(at + PAIN, score="7", place="thumb", when="during")
    clinic.outcomes.add(CONSOLE, named, "arat", 12, side="left")
    answer = visitor.get(at + tail, **{"accept-language": "it"})
    assert answer.status_code == 200
    assert '<html lang="it">' in answer.text


def test_sessions_and_own_takes_are_listed_and_mirrored_ones_marked(browser, clinic, at):
    named = at.rsplit("/", 1)[1]
    for number in range(7):
        digest = hashlib.sha256(f"{named} {number}".encode()).hexdigest()
        path, begun = f"{named}-{number}.mcap", 1_790_000_000_000_000_000 + number
        therapy = TherapySession(
            patient=named, sha256=digest, path=path, mode="passive", started_utc_ns=begun
        )
        clinic.catalogue.add_session(therapy)
    digest = hashlib.sha256(named.encode()).hexdigest()
    shown = Take(
        sha256=digest, path=f"{named}.mcap", side="right", exercise="open_close", source="camera",
        duration_s=4.0, subject_id=named,
    )  # fmt: skip
    take = clinic.catalogue.add_take(shown)
    overview, everything = browser("auditor").get(at).text, browser("auditor").get(f"{at}/sessions").text
    assert (overview.count('href="/sessions/'), everything.count('href="/sessions/')) == (5 * 3, 7 * 3)
    assert "All 7" in overview
    assert f"/takes/{take.id}" in everything
    assert "played mirrored" in everything


def test_limits_say_whether_they_were_measured_today_and_what_was_before(browser, clinic, at):
    named, visitor = at.rsplit("/", 1)[1], browser("auditor")
    assert "Shipped defaults" in visitor.get(f"{at}/limits").text
    view = clinic.limit_history.show(named)
    clinic.limits.set_torque(CONSOLE, named, "index_pip", 0.05, reason=ATTACK)
    narrow = limits_to_json(view.today.limits)
    noon = time.time_ns()

    def measured(ago_ns, lasts_ns):
        clinic.catalogue.add_day_limits(
            DayLimits(
                patient=named,
                side="left",
                device="exoskeleton",
                wrist_rad=0.35,
                content=narrow,
                measured_utc_ns=noon - ago_ns,
                expires_utc_ns=noon - ago_ns + lasts_ns,
                by="bert",
            )
        )

    measured(2 * DAY_NS, DAY_NS)
    stale = visitor.get(f"{at}/limits").text
    assert 'role="alert"' in stale
    assert "expired" in stale
    assert "⚠" in visitor.get(at).text
    measured(0, DAY_NS)
    told = text_of(visitor.get(f"{at}/limits"))
    assert "Measured today" in told
    assert "wrist at 20 degrees" in told
    assert "Index PIP Torque 0.05 Nm <img" in told
    assert ATTACK not in visitor.get(f"{at}/limits").text
    assert "measured today by bert" in text_of(visitor.get(at))
