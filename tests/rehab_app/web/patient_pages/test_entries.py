"""Journal, outcomes, plan, sessions and limits on the pages of a patient."""

from __future__ import annotations

import hashlib
import time

import pytest

from rehab_app.access import CONSOLE
from rehab_app.services.limits_json import limits_to_json
from rehab_app.services.plan_items import Plan, PlanItem
from sessions.catalogue import DayLimits, Take, TherapySession

from ..conftest import ATTACK
from .conftest import DAY_NS, EVENT, NOTE, PAIN, TABS, text_of


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
