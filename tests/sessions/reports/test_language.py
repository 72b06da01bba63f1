"""Reports in Italian: every text has its translation, numbers a comma, and programs still read English."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
from babel.messages.pofile import read_po

import sessions.reports
from sessions.errors import Refused
from sessions.metrics import DEFINITIONS, measure
from sessions.reports import FORMATS, Report
from sessions.reports.language import LANGUAGES, SOURCE, decimal, moment, speaking
from sessions.reports.progress import Beside
from sessions.reports.progress_formats import PROGRESS_FORMATS, render_progress
from sessions.reports.remarks import SAID, remark
from sessions.reports.wording import joint_words, number

from .pasts import past, progress

Make = Callable[..., Any]
OTHERS = sorted(set(LANGUAGES) - {SOURCE})
PLACEHOLDER = re.compile(r"%\(\w+\)s|%%")
WORDED = sorted(name for name, made in FORMATS.items() if made.worded)


@pytest.fixture(scope="module")
def said() -> set[Any]:
    """Every text of the reports: a message, or a pair of one and many."""
    found: set[Any] = set(SAID)
    for known in DEFINITIONS.values():
        found |= {known.title, known.meaning}
    for path in Path(str(sessions.reports.__file__)).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                wanted = {"_": 1, "marked": 1, "counted": 2}.get(node.func.id, 0)
                texts = [one.value for one in node.args[:wanted] if isinstance(one, ast.Constant)]
                if wanted and len(texts) == wanted:
                    found.add(texts[0] if wanted == 1 else tuple(texts))
    return found


@pytest.fixture(scope="module", params=OTHERS)
def catalogue(request: pytest.FixtureRequest) -> Any:
    text = (resources.files("web_assets") / "reports" / f"{request.param}.po").read_text(encoding="utf-8")
    return read_po(text.splitlines(), locale=request.param, abort_invalid=True)


def test_every_text_has_a_translation_and_nothing_else_is_held(said: set[Any], catalogue: Any) -> None:
    held = {one.id for one in catalogue if one.id and one.string and all(one.string)}
    assert said - held == set()
    assert held - said == set()


def test_translations_keep_their_placeholders(catalogue: Any) -> None:
    for one in catalogue:
        if one.id:
            texts = [one.id, one.string] if isinstance(one.id, str) else [one.id[1], one.string[1]]
            assert not one.fuzzy, one.id
            assert sorted(PLACEHOLDER.findall(texts[0])) == sorted(PLACEHOLDER.findall(texts[1])), one.id


def test_no_remark_of_a_measurement_stays_english(make_take: Make, make_session: Make) -> None:
    recordings = [make_take(), make_session(stopped=True), make_session(repetitions=1)]
    remarks = {item.status.partition(": ")[2] for made in recordings for item in measure(made).metrics}
    remarks |= {measure(made).conditions for made in recordings} - {""}
    with speaking("it"):
        for text in remarks - {""}:
            for part in text.split("; "):
                assert remark(part) != part, part


@pytest.mark.parametrize("name", WORDED)
def test_a_worded_format_is_in_the_language(name: str, make_take: Make, make_session: Make) -> None:
    report = Report((measure(make_take()), measure(make_session())), "0.1.0")
    english, italian = (FORMATS[name].made(report, language) for language in ("en", "it"))
    assert english != italian
    if name == "pdf":
        return
    text = italian.decode()
    for words in ("mano destra", "Movimento registrato", "modalità passiva", "0,90 Nm/rad"):
        assert words in text, words
    for words in ("right hand", "Recorded", "full repetition", "the robot", "not measured", "Stiffness"):
        assert words not in re.sub(r"<td>[^<]*/[^<]*</td>", "", text), words
    if name == "html":
        assert '<html lang="it">' in text
        assert not re.search(r">\s*-?\d+\.\d+\s*<", text)


def test_formats_for_programs_take_no_notice(make_session: Make) -> None:
    report = Report((measure(make_session()),), "0.1.0")
    for name in ("json", "csv"):
        assert FORMATS[name].made(report, "it") == FORMATS[name].made(report, "en")
    found = progress(past(0), past(1, pip_deg=50.0))
    for name in ("json", "csv"):
        assert render_progress(found, name, "it") == render_progress(found, name)
    assert "Italian" not in str(PROGRESS_FORMATS)


def test_progress_in_italian() -> None:
    beside = Beside(
        "range_of_motion", "index_pip", 0.7, 0.8, 1.0, 1.2, "n = 12, this clinic, age 60-69", 0, "1"
    )
    found = replace(progress(past(0), past(1, pip_deg=50.0)), norms=(beside,))
    page = render_progress(found, "html", "it").decode()
    for words in (
        "Ha fatto 2 sedute",
        "un guadagno reale di 10°",
        "n = 12, questa clinica, età 60-69",
        "sotto",
    ):
        assert words in page, words
    assert "un guadagno reale" not in render_progress(found, "html").decode()
    assert "Variazioni reali" in render_progress(found, "note", "it").decode()


def test_an_unknown_language_is_refused_and_the_old_one_comes_back(make_take: Make) -> None:
    report = Report((measure(make_take()),), "0.1.0")
    with pytest.raises(Refused, match="language"):
        FORMATS["note"].made(report, "xx")
    with speaking("it"):
        assert decimal("1.5 of 2.5") == "1,5 of 2,5"
    assert decimal("1.5") == "1.5"


def test_numbers_names_and_days_of_the_language() -> None:
    assert moment(1_790_000_000_000_000_000) == "21 September 2026, 14:13 UTC"
    with speaking("it"):
        assert moment(1_790_000_000_000_000_000) == "21 settembre 2026, 14:13 UTC"
        assert number("range_of_motion", "rad", 1.0) == "57,3"
        assert joint_words("index_pip") == "indice, articolazione media (IFP)"
