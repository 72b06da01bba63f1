"""Lists that offer a few of many: what stands in them, what a search finds, what stays chosen."""

from __future__ import annotations

import re

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.web import create_app
from tests.bench.large_clinic import Size, fill
from tests.rehab_app.web.conftest import ATTACK, Browser, NoPictures

MANY = Size(patients=60, sessions=300, takes=120)


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    folder = tmp_path_factory.mktemp("many")
    url = f"sqlite:///{folder / 'clinic.sqlite3'}"
    with open_clinic(folder, settings=Settings(catalogue_url=url)) as clinic:
        clinic.accounts.add_user("therapist", "therapist", "correct horse battery", CONSOLE)
        fill(clinic, url, MANY)
        clinic.patients.add(
            CONSOLE, given_name=ATTACK, family_name="O'Hara & Sons", birth_date="1957-03-14", side="left"
        )
        yield clinic


@pytest.fixture(scope="module")
def visitor(many):
    return Browser(create_app(many, open_viewports=lambda _: NoPictures()), "therapist")


def options(html, name):
    """What a list offers: the values, and those that are chosen."""
    held = re.search(rf'<select name="{name}"[^>]*>(.*?)</select>', html, re.DOTALL)[1]
    tags = re.findall(r"<option ([^>]*)>", held)
    values = [re.search(r'value="([^"]*)"', tag)[1] for tag in tags]
    return values, [value for value, tag in zip(values, tags, strict=True) if "selected" in tag]


def searched(html, name):
    """Whether the field that searches a list is shown."""
    tag = re.search(rf'<div class="chooser" data-chooser="{name}"[^>]*>', html)[0]
    return not tag.endswith(" hidden>")


def test_the_live_page_offers_a_few_of_many(visitor, many):
    html = visitor.get("/live").text
    for name in ("patient", "whom"):
        values, chosen = options(html, name)
        assert len(values) == 21
        assert chosen == []
        assert searched(html, name)
    takes, _ = options(html, "take")
    assert len(takes) == 20
    assert searched(html, "take")
    newest = many.patients.search(order="-added").patients[0].id
    assert newest in options(html, "patient")[0]


def test_a_link_to_anybody_holds(visitor, many):
    html = visitor.get("/live").text
    known, offered = {one.id for one in many.patients.list()}, set(options(html, "patient")[0])
    hidden = sorted(known - offered)[0]
    far = many.takes.list()[-1].id
    assert many.takes.get(far).approved_by
    assert far not in options(html, "take")[0]
    html = visitor.get(f"/live?patient={hidden}&take={far}").text
    assert options(html, "patient")[1] == [hidden]
    assert options(html, "whom")[1] == [hidden]
    assert options(html, "take")[1] == [far]
    patient = many.patients.get(hidden)
    tag = re.search(rf'<option value="{hidden}"[^>]*>', html)[0]
    assert f'data-side="{patient.side}"' in tag
    assert patient.family_name.replace("'", "&#39;") in tag


def test_nobody_archived_and_no_take_that_nobody_approved_is_offered(visitor, many):
    gone = many.patients.search(archived=True).patients[0].id
    waiting = next(row.id for row in many.takes.list() if row.approved_by is None)
    html = visitor.get(f"/live?patient={gone}&take={waiting}").text
    assert gone not in options(html, "patient")[0]
    assert waiting not in options(html, "take")[0]
    assert visitor.get(f"/live/patients?find={gone}").json()["rows"] == []
    answer = visitor.get(f"/live/takes?take={waiting}").json()
    assert answer["take"] == {"id": waiting, "approved_by": None}
    assert waiting not in [row["id"] for row in answer["rows"]]


def test_a_patient_is_found_by_name_birth_date_and_pseudonym(visitor, many):
    def found(typed):
        return visitor.send("GET", "/live/patients", params={"find": typed}).json()

    one = many.patients.get("P-0002")
    day, month, year = (int(part) for part in reversed(one.birth_date.split("-")))
    for typed in (one.family_name, f"{one.family_name}, {one.given_name}", f"{day}.{month}.{year}", "p-0002"):
        assert "P-0002" in [row["id"] for row in found(typed)["rows"]], typed
    (row,) = found("O'Hara")["rows"]
    assert row["data"]["name"] == f"{ATTACK} O'Hara & Sons"
    assert row["data"]["side"] == "left"
    assert row["data"]["born"] == "born 14 March 1957"
    assert row["more"] == "born 14 March 1957, left"
    assert found("nobody at all") == {"rows": [], "total": 0}
    everybody = found("1")
    assert len(everybody["rows"]) == 20 < everybody["total"]
    assert visitor.get("/live/patients?find=" + "x" * 5000).status_code == 200
    assert visitor.send("GET", "/live/patients", params={"find": "a\x00b"}).status_code in (200, 404)


def test_a_search_among_patients_leaves_a_row_in_the_audit(visitor, many):
    visitor.get("/live/patients?find=rossi")
    many.audit.close()
    rows = many.catalogue.audit(50)
    many.audit.start()
    assert [row.detail for row in rows if row.detail.startswith("/live/patients")] == ["/live/patients"]


def test_a_take_is_found_in_the_language_of_the_page(visitor):
    def found(typed, language="en", **more):
        asked = {"find": typed, **more}
        headers = {"accept-language": language}
        return visitor.send("GET", "/live/takes", params=asked, headers=headers).json()

    left = found("pinch left")
    assert left["total"] == 20
    assert all(row["name"].startswith("Tip pinch, left") for row in left["rows"])
    assert found("pinza sinistra", "it")["total"] == left["total"]
    assert found("left", exercise="pinch")["total"] == left["total"]
    assert found("left", exercise="open_close")["total"] == 0
    one = left["rows"][-1]["id"]
    assert [row["id"] for row in found(one[:7])["rows"]] == [one]
    assert one in [row["id"] for row in found("", keep=one)["rows"]]


def test_takes_come_page_by_page(visitor):
    first, last = visitor.get("/takes").text, visitor.get("/takes?page=999").text
    link = re.compile(r'<a href="/takes/([0-9a-f]+)"')
    assert len(link.findall(first)) == 50
    assert len(link.findall(last)) == 20
    assert "page 3 of 3" in last
    assert not set(link.findall(first)) & set(link.findall(last))
    assert "sort.js" not in first
    narrowed = visitor.get("/takes?find=pinch&side=left&page=2").text
    assert 'value="pinch"' in narrowed
    assert "40 takes" in narrowed
    assert "sort.js" in narrowed
    assert 'href="/takes?find=left&amp;page=2"' in visitor.get("/takes?find=left").text
    assert visitor.get("/takes?page=x&approval=maybe").status_code == 200


def test_takes_are_found_by_whose_hand_it_is(visitor, many):
    (row, *_) = [row for row in many.takes.list() if row.subject in {one.id for one in many.patients.list()}]
    patient = many.patients.get(row.subject)
    for query in (f"find={patient.id}", f"find={patient.family_name}", f"patient={patient.id}"):
        html = visitor.get(f"/takes?{query}").text
        assert f'href="/takes/{row.id}"' in html
    assert options(html, "patient")[1] == [patient.id]
    assert '<select name="patient"' not in visitor.get("/takes").text


def test_a_plan_offers_the_takes_of_its_exercise(visitor, many):
    html = visitor.get("/patients/P-0042/plan?add=open_close").text
    values, _ = options(html, "take")
    approved = [
        row.id for row in many.takes.list() if row.exercise == "open_close" and row.approved_by is not None
    ]
    assert values == ["", *approved]
    assert not searched(html, "take")
    assert "choose.js" not in visitor.get("/patients/P-0042/plan").text


def test_a_plan_plays_the_newest_approved_take_of_its_side(visitor, many):
    plan = many.plans.current("P-0042")
    side = many.patients.get("P-0042").side
    rows = [row for row in many.takes.list() if row.exercise == "open_close" and row.approved_by]
    expected = next((row for row in rows if row.side == side), rows[0])
    assert many.plans.playables(plan) == (expected,)
    assert f'href="/takes/{expected.id}"' in visitor.get("/patients/P-0042/plan").text


def test_the_library_offers_a_few_patients(visitor):
    html = visitor.get("/exercises/open_close").text
    assert len(options(html, "patient")[0]) == 21
    assert searched(html, "patient")


def test_a_small_clinic_needs_no_search(browser):
    html = browser("therapist").get("/live").text
    assert not searched(html, "patient")
    assert not searched(html, "whom")
    assert 'name="find"' not in browser("therapist").get("/takes").text
    assert "/static/choose.js" in html  # a take more, and the field is needed
