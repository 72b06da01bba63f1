"""Every form of every page by the same laws: required, range, unicode, 10,000 characters, an ended sign-in.

The forms are found by reading the pages, so that a new one is tried without a line here.
"""

from __future__ import annotations

import html
import re

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.web import create_app

from .conftest import PASSWORD, Browser, NoPictures
from .form_crawl import forms_of
from .test_matrix import VERBS, path_of

LONG = "é" * 10_000
ATTACK = "<img src=x onerror=alert(1)>"
FOREIGN = f"Ünï ☃ 漢字 مرحبا {ATTACK} 'quoted\""
HIDDEN = "a\u202eb"
NO_NUMBERS = ("1,5,5", "nan", "-1e9")
# Sign-in, stop and language have tests of their own; these other acts take the clinic from under this test.
APART = re.compile(
    r"/(sign-in|sign-out|unlock|stop|stop/clear|language|live/pain|account/sign-out)|.*/archive"
)
SECRET = ("password", "passphrase")
NO_PAGE = re.compile(r"\.\w+$|\{(format|kind|which)\}|/file/|/kept|report")
PLAN = "/patients/P-0001/plan"


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("forms")) as opened:
        opened.accounts.set_up("ada", PASSWORD)
        opened.accounts.add_user("bert", "therapist", PASSWORD, CONSOLE)
        opened.patients.add(CONSOLE, given_name="A", family_name="L", birth_date="1950-12-31", side="left")
        for seed in (3, 4):
            opened.takes.record_virtual("open_close", "left", 1.5, seed, CONSOLE)
        opened.takes.approve(opened.takes.list()[0].id, CONSOLE)
        yield opened


@pytest.fixture(scope="module")
def app(held):
    made = create_app(held, open_viewports=lambda _: NoPictures())
    ada = Browser(made, "ada")
    stated = {"diagnosis": "flexor-tendon-repair", "event_date": "2026-11-01"}
    assert ada.post("/patients/P-0001/diagnosis", **stated).status_code == 303
    item = next(form for form in forms_of(PLAN, ada.get(f"{PLAN}?add=").text) if form.path.endswith("/item"))
    assert ada.post(item.path, **item.filled()).status_code == 303
    secret = {"passphrase": PASSWORD, "again": PASSWORD}
    assert ada.post("/clinic/backup/passphrase", **secret).status_code == 303
    return made


@pytest.fixture
def ada(app):
    return Browser(app, "ada")


@pytest.fixture(scope="module")
def forms(app, held):
    """Every form by the path that it is sent to."""
    ada, found = Browser(app, "ada"), {}
    for page in [*pages(held), f"{PLAN}?add=", f"{PLAN}?edit=1", "/patients/P-0001/outcomes?measure=grip"]:
        answer = ada.get(page)
        if "html" in answer.headers.get("content-type", ""):
            for form in forms_of(page, answer.text):
                if not APART.fullmatch(form.path):
                    found.setdefault(form.path, form)
    return found


def pages(clinic):
    """Paths of all pages that show something of this clinic."""
    for line in sorted(VERBS):
        if line.startswith("GET ") and not NO_PAGE.search(line):
            path = path_of(line).replace("P-9999", "P-0001")
            yield from {path.replace("0" * 8, take.id) for take in clinic.takes.list()}


def sent(app, form, **changed):
    """The answer to a form, and the page that a browser shows then, with its entities resolved."""
    ada = Browser(app, "ada")
    answer = ada.post(form.path, **{**form.filled(), **changed})
    shown = ada.get(answer.headers["location"].split("#")[0]) if answer.status_code == 303 else answer
    assert ATTACK not in shown.text, form.path
    return answer, html.unescape(shown.text)


def taken(answer, page):
    return answer.status_code == 303 and "notice good" in page


def tried(form):
    """Forms that text can be tried on; a secret is never shown again, and a file is no page."""
    return not any(word in one.name for one in form.fields for word in SECRET) and "export" not in form.path


def test_the_reading_finds_the_forms(forms):
    assert len(forms) > 30
    ends = "item frame move unlock edit note pain event outcomes consent erase retouch withdraw place aim"
    assert [end for end in ends.split() if not any(path.endswith(f"/{end}") for path in forms)] == []


def test_what_must_be_filled_in_is_asked_for(app, forms):
    missing = []
    for form in filter(tried, forms.values()):
        for one in form.fields:
            if one.required and taken(*sent(app, form, **{one.name: ""})):
                missing.append((form.path, one.name))
    assert missing == []


def test_no_text_harms_and_what_is_refused_is_shown_again(app, forms):
    """10,000 characters, other scripts, markup, characters that no screen shows."""
    wrong = []
    for form in filter(tried, forms.values()):
        for one in form.fields:
            for text in (LONG, HIDDEN, FOREIGN) if one.kind != "checkbox" and not one.numeric else ():
                answer, page = sent(app, form, **{one.name: text})
                kept = taken(answer, page) or not one.typed or text in page
                answered = (303, 409, 200) if one.kind == "hidden" else (303, 409)
                if answer.status_code not in answered or not kept:
                    wrong.append((form.path, one.name, text[:4], answer.status_code))
    assert wrong == [], wrong


def test_numbers_have_a_range_with_its_unit_and_nothing_else_is_taken(app, forms):
    wrong = []
    for form in filter(tried, forms.values()):
        for one in form.fields:
            if one.numeric and not one.told:
                wrong.append((form.path, one.name, "no range"))
            for text in NO_NUMBERS if one.numeric else ():
                answer, page = sent(app, form, **{one.name: text})
                if answer.status_code not in (303, 409) or taken(answer, page) or text not in page:
                    wrong.append((form.path, one.name, text, answer.status_code))
    assert wrong == [], wrong


def test_an_ended_sign_in_loses_no_text(app, held, forms):
    lost = []
    for form in filter(tried, forms.values()):
        typed = [one.name for one in form.fields if one.typed]
        ada = Browser(app, "ada")
        held.accounts.sign_ins.end_all("ada")
        answer = ada.post(form.path, **{**form.filled(), **dict.fromkeys(typed, FOREIGN)})
        if typed and answer.headers.get("location") != "/sign-in?next=%2Fkept":
            lost.append((form.path, answer.status_code))
        elif typed:
            ada.cookies.update(Browser(app, "ada").cookies)
            page = ada.get("/kept").text
            assert ATTACK not in page
            if html.unescape(page).count(FOREIGN) < len(typed) or f'action="{form.path}"' not in page:
                lost.append((form.path, "kept"))
    assert lost == []


APPENDED = re.compile(
    r".*/(note|pain|event|outcomes|consent|item|retouch|withdraw|lock|unlock|erase|next)|/exercises|.*/users|/patients|.*/place"
)


def test_a_form_that_changes_a_record_says_from_what_it_was_made(forms):
    """Else the second of two people would write over the first unknowing."""
    bare = []
    for form in filter(tried, forms.values()):
        marks = {one.name for one in form.fields if one.kind == "hidden"}
        edits = any(one.value and (one.typed or one.kind == "select") for one in form.fields)
        if edits and not any(re.match(r"version|since|was|corrects", mark) for mark in marks):
            bare.append(form.path)
    assert [path for path in bare if not APPENDED.fullmatch(path)] == []


PAGES = {path: path for path in ("/clinic/settings", "/clinic/users", "/clinic/backup")}


@pytest.mark.parametrize(
    ("path", "field", "values"),
    [
        ("/clinic/settings/name", "value", ("North", "South")),
        ("/clinic/settings/aim", "value", ("65", "62,5")),
        ("/clinic/settings/idle", "value", ("20", "25")),
        ("/clinic/users/idle", "minutes", ("20", "25")),
        ("/clinic/backup/retention", "years", ("12", "14")),
        ("/clinic/backup/place", "place", None),
        ("/patients/P-0001/aim", "percent", ("65", "62,5")),
    ],
)
def test_the_second_of_two_people_is_told_and_both_values_are_shown(app, tmp_path, path, field, values):
    home = PAGES.get(path.rpartition("/")[0], f"{path.rpartition('/')[0]}/next")
    shown = forms_of(home, Browser(app, "ada").get(home).text)
    was = next(form.filled()["was"] for form in shown if form.path == path)
    first, second = values or (str(tmp_path / "one"), str(tmp_path / "two"))
    sends = Browser(app, "ada"), Browser(app, "ada")
    assert sends[0].post(path, **{"was": was, field: first}).status_code == 303
    late = sends[1].post(path, **{"was": was, field: second})
    assert late.status_code == 409
    page = html.unescape(late.text)
    assert f"{first!r} by somebody else" in page
    assert f'value="{second}"' in page
    (again,) = {one.filled()["was"] for one in forms_of(path, late.text) if one.path == path}
    assert again == first
    assert sends[1].post(path, **{"was": again, field: was}).status_code == 303
