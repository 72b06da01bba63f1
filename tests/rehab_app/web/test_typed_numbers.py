"""Numbers are typed with comma or point alike, in every field of every form."""

from __future__ import annotations

import ast
import math
import re
from importlib import resources
from pathlib import Path
from types import SimpleNamespace

import pytest

import rehab_app
from rehab_app.errors import Refused
from rehab_app.services.outcome_measures import measure
from rehab_app.web.pages.asked import decimal, number
from rehab_app.web.pages.patient_diagnosis import _millimetres
from rehab_app.web.pages.patient_fields import _length_m

PAGES = Path(rehab_app.__file__).parent / "web" / "pages"
TEMPLATES = Path(str(resources.files("web_assets") / "templates"))
FIELD = re.compile(r'<input[^>]*(?:type="number"|inputmode="(?:decimal|numeric)")[^>]*>')
NAME = re.compile(r'name="(\w+)"')
READ = re.compile(r'(?:number|whole)\(\s*visit,\s*"(\w+)"|decimal\([^()]*asked\("(\w+)"')
# read by functions of their own, each tried below
BY_ITSELF = {"hand_length_cm", "value", "score"}


@pytest.mark.parametrize(
    ("typed", "value"), [("1,5", 1.5), ("1.5", 1.5), ("-0,25", -0.25), ("70", 70.0), (" 2,0 ", 2.0)]
)
def test_comma_and_point_are_the_same(typed, value):
    visit = SimpleNamespace(asked=lambda _: typed)
    assert decimal(typed) == value
    assert number(visit, "speed", "speed", "a number") == value


@pytest.mark.parametrize("typed", ["", "1,5,5", "1.000,5", "x", "1;5", "inf", "nan"])
def test_what_is_no_number_is_refused(typed):
    with pytest.raises(Refused):
        number(SimpleNamespace(asked=lambda _: typed), "speed", "speed", "a number")


def test_the_fields_that_read_for_themselves_take_a_comma():
    assert _length_m("18,5") == _length_m("18.5") == pytest.approx(0.185)
    assert _millimetres("25,5") == _millimetres("25.5") == pytest.approx(0.0255)
    assert measure("tardieu-r1").read("30,5") == pytest.approx(math.radians(30.5))


def test_no_form_has_a_number_that_is_read_another_way():
    """Every numeric field of the templates is named where pages read numbers."""
    sources = "\n".join(path.read_text(encoding="utf-8") for path in PAGES.glob("*.py"))
    read = {name for found in READ.findall(sources) for name in found if name}
    shown = {
        name
        for path in TEMPLATES.glob("*.j2")
        for field in FIELD.findall(path.read_text(encoding="utf-8"))
        for name in NAME.findall(field)
    }
    assert len(shown) > 15
    assert shown - read - BY_ITSELF == set()


def test_text_becomes_a_number_in_one_place_only():
    found = [
        f"{path.name}: {ast.unparse(call)}"
        for path in PAGES.glob("*.py")
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "float"
        if not ast.unparse(call).endswith(".max())")  # a number of numpy
    ]
    assert len([one for one in found if one.startswith("asked.py")]) == 1
    assert len(found) == 1
