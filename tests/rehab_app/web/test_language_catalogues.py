"""The catalogues hold every text of the pages, with its placeholders, and nothing that no page says."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import pytest
from babel.messages.extract import DEFAULT_KEYWORDS, extract_from_file
from babel.messages.pofile import read_po

import rehab_app
from rehab_app.services import runner_steps
from rehab_app.services.exercises import STARTERS
from rehab_app.web.language import LANGUAGES, SOURCE, _, speak

WEB = Path(rehab_app.__file__).parent / "web"
ASSETS = Path(str(resources.files("web_assets") / "locale")).parent
PLACEHOLDER = re.compile(r"%\(\w+\)[.\d]*[a-z]|%%|\{\w+\}")
OTHERS = sorted(set(LANGUAGES) - {SOURCE})


@pytest.fixture(scope="module")
def said():
    """Every text of the pages: message to where it stands."""
    found = {}
    scripts = [*WEB.rglob("*.py"), Path(runner_steps.__file__)]
    for path in [*scripts, *(ASSETS / "templates").glob("*.j2")]:
        method = "python" if path.suffix == ".py" else "jinja2"
        options = {"extensions": "jinja2.ext.i18n", "encoding": "utf-8"}
        keywords = DEFAULT_KEYWORDS | {"marked": None}
        for line, message, *_rest in extract_from_file(method, path, keywords=keywords, options=options):
            found.setdefault(message, f"{path.name}:{line}")
    return found


@pytest.fixture(scope="module", params=OTHERS)
def catalogue(request):
    with (ASSETS / "locale" / f"{request.param}.po").open("rb") as file:
        return read_po(file, locale=request.param, abort_invalid=True)


def placeholders(texts):
    return {
        one for text in ([texts] if isinstance(texts, str) else texts) for one in PLACEHOLDER.findall(text)
    }


def test_the_extraction_finds_templates_tables_and_scripts(said):
    assert len(said) > 1000
    assert {
        "EMERGENCY STOP",
        "Overview",
        "NO CONNECTION: this picture is old",
        "Straight fist",
    } <= said.keys()


def test_every_text_has_a_translation(said, catalogue):
    held = {one.id for one in catalogue if one.id and one.string and all(one.string)}
    missing = {message: where for message, where in said.items() if message not in held}
    assert not missing


def test_nothing_is_held_that_no_page_says(said, catalogue):
    assert not {one.id for one in catalogue if one.id} - said.keys()
    assert not catalogue.obsolete


def test_translations_are_certain_and_keep_their_placeholders(catalogue):
    for one in catalogue:
        if one.id:
            assert not one.fuzzy, one.id
            assert placeholders(one.string) == placeholders(one.id), one.id


def test_plurals_have_as_many_forms_as_the_language(catalogue):
    for one in catalogue:
        if one.pluralizable and one.id:
            assert len(one.string) == catalogue.num_plurals, one.id


@pytest.mark.parametrize("language", OTHERS)
def test_names_of_exercises_are_translated(language):
    speak(language)
    try:
        assert [one.words for one in STARTERS if _(one.words) == one.words] == []
    finally:
        speak(SOURCE)
