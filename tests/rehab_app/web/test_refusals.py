"""A refusal on a page: one sentence, in one language."""

from __future__ import annotations

import pytest

from rehab_app.errors import Refused
from rehab_app.web import refusals
from rehab_app.web.language import _, speak
from rehab_app.web.refusals import sentence_of

EMPTY = Refused("birth date", "empty", "filled in", "fill it in")


@pytest.fixture
def italian():
    speak("it")
    yield
    speak("en")


def test_english_is_the_sentence_of_the_service():
    assert sentence_of(EMPTY) == "Birth date is empty, but must be filled in: fill it in."


def test_known_parts_are_said_in_the_language_of_the_page(italian):
    assert sentence_of(EMPTY) == "Data di nascita: vuoto. Atteso: compilato. Da fare: compilare."


@pytest.mark.parametrize(
    ("refusal", "told"),
    [
        (Refused("speed", "2", "0.1 to 1", "choose a speed within it"), "Velocità: 2. Atteso: da 0.1 a 1."),
        (Refused("note", "2001 characters long", "at most 2000 characters", "shorten it"), "al massimo 2000"),
        (Refused("hand length", "3 m", "0.10 to 0.26 m", "correct it"), "da 0.10 a 0.26 m"),
        (Refused("event date", "'soon'", "a date as YYYY-MM-DD", "correct it"), "Data dell'evento: 'soon'."),
    ],
)
def test_numbers_and_quoted_words_stay_as_they_are(italian, refusal, told):
    assert told in sentence_of(refusal)


@pytest.mark.parametrize("strange", range(4))
def test_a_sentence_is_never_half_of_each(italian, strange):
    parts = ["birth date", "empty", "filled in", "fill it in"]
    parts[strange] = "a thing that nobody translated"
    assert sentence_of(Refused(*parts)) == sentence_of(Refused(*parts)).replace("Atteso", "")
    assert "a thing that nobody translated" in sentence_of(Refused(*parts)).lower()
    assert "but must be" in sentence_of(Refused(*parts))


def test_every_known_part_is_translated(italian):
    same = {word for word in refusals._WORDS if _(word) == word}
    assert same <= {"password"}
