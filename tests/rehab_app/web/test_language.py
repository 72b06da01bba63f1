"""The language of a request: chosen, else asked for by the browser, else English; never somebody else's."""

from __future__ import annotations

import pytest
from starlette.datastructures import Headers

from rehab_app.web.language import COOKIE, LANGUAGES, _, asked_for, speak, spoken
from rehab_app.web.render import page_templates


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


def test_a_text_that_a_person_typed_is_never_called_safe():
    pages = page_templates()
    attack = "<img src=x onerror=alert(1)> 100 %(n)s %"
    shown = pages.from_string("{{ _(typed) }}").render(typed=attack)
    assert "<img" not in shown
    assert "100 %(n)s %" in shown
    filled = pages.from_string('{{ _("Hello %(name)s, 50 %%", name=typed) }}').render(typed=attack)
    assert filled.startswith("Hello &lt;img")
    assert filled.endswith(", 50 %")
    assert pages.from_string('{{ _("50 %%") }}').render() == "50 %"
    block = "{% trans name=typed %}Hello {{ name }}{% endtrans %}"
    assert "<img" not in pages.from_string(block).render(typed=attack)
    counted = pages.from_string('{{ ngettext("%(num)s day", "%(num)s days", n) }}')
    assert (counted.render(n=1), counted.render(n=3)) == ("1 day", "3 days")
