"""The language of a request: chosen, else asked for by the browser, else English; never somebody else's."""

from __future__ import annotations

import pytest
from starlette.datastructures import Headers

from rehab_app.web.language import COOKIE, LANGUAGES, _, asked_for, speak, spoken


@pytest.mark.parametrize(
    ("accept", "cookie", "expected"),
    [
        ("it-IT,it;q=0.9,en;q=0.8", "", "it"),
        ("fr-FR,it;q=0.5", "", "it"),
        ("fr", "", "en"),
        ("", "", "en"),
        ("it", "en", "en"),
        ("en", "it", "it"),
        ("it", "xx", "it"),
        (";;;,,," * 100, "", "en"),
    ],
)
def test_the_choice_on_a_page_counts_before_the_browsers(accept, cookie, expected):
    headers = Headers({"accept-language": accept} if accept else {})
    assert asked_for(headers, {COOKIE: cookie} if cookie else {}) == expected


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_no_catalogue_holds_stays_as_it_is(language):
    speak(language)
    assert spoken() == language
    assert _("no catalogue holds this sentence") == "no catalogue holds this sentence"
    assert _("") == ""
    speak("en")


def test_an_unknown_language_is_english():
    speak("../../secret")
    assert spoken() == "en"


def test_the_next_request_does_not_inherit_the_language(browser):
    nurse = browser("therapist")
    page = nurse.get("/patients", **{"accept-language": "it"})
    assert '<html lang="it">' in page.text
    assert "Pazienti" in page.text
    assert '<html lang="en">' in nurse.get("/patients").text
