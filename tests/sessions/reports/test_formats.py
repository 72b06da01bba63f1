"""One content in many formats: PDF, CSV, Parquet, FHIR, the short note."""

from __future__ import annotations

import base64
import csv
import io
import json
import math
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from sessions.errors import Refused
from sessions.metrics import DEFINITIONS, measure
from sessions.reports import FORMATS, Report, render_note, render_pdf
from sessions.reports.fhir import render_fhir
from sessions.reports.fhir_observations import UCUM_OF
from sessions.reports.long_rows import COLUMNS, render_csv, render_parquet

Make = Callable[..., Any]


@pytest.fixture
def report(make_take: Make, make_session: Make) -> Report:
    return Report((measure(make_take()), measure(make_session(stopped=True))), "0.1.0")


@pytest.fixture
def evil(make_session: Make) -> Report:
    """A report whose words are code elsewhere: typst, a spreadsheet, HTML; and letters that no font has."""
    session = make_session()
    session.header = replace(session.header, exercise='=1+1 #panic("x") *手を開く* <b>')
    return Report((measure(session),), "0.1.0")


def test_the_pdf_is_for_archives_embeds_its_fonts_and_repeats(report: Report) -> None:
    made = render_pdf(report)
    assert made.startswith(b"%PDF-1.7")
    assert b"pdfaid:part>2<" in made.replace(b" ", b"")
    assert b"/FontFile" in made
    assert b"DejaVuSans" in made
    assert made == render_pdf(report)


def test_words_of_a_file_are_no_code_in_a_pdf(evil: Report) -> None:
    assert render_pdf(evil).startswith(b"%PDF")


def test_csv_has_a_row_per_number_and_an_empty_field_where_there_is_none(report: Report) -> None:
    rows = list(csv.DictReader(io.StringIO(render_csv(report).decode())))
    metrics = [item for summary in report.summaries for item in summary.metrics]
    assert len(rows) == len(metrics)
    assert tuple(rows[0]) == COLUMNS
    for row, item in zip(rows, metrics, strict=True):
        assert (row["name"], row["subject"], row["unit"]) == (item.name, item.subject, item.unit)
        assert (row["value"] == "") == (not item.measurable)
        if item.measurable:
            assert float(row["value"]) == item.value


def test_no_cell_of_the_csv_is_a_formula(evil: Report) -> None:
    rows = csv.DictReader(io.StringIO(render_csv(evil).decode()))
    assert {row["exercise"][:2] for row in rows} == {"'="}


def test_parquet_holds_what_the_csv_holds(report: Report) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(io.BytesIO(render_parquet(report)))
    rows = list(csv.DictReader(io.StringIO(render_csv(report).decode())))
    assert tuple(table.column_names) == COLUMNS
    for one, other in zip(table.to_pylist(), rows, strict=True):
        assert one["status"] == other["status"]
        assert one["value"] == (float(other["value"]) if other["value"] else None)


def test_parquet_without_its_extra_is_a_sentence(report: Report, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(Refused, match=r"rehab-app\[parquet\]"):
        render_parquet(report)


def test_the_bundle_is_valid_and_its_references_meet(report: Report) -> None:
    from fhir.resources.R4B.bundle import Bundle

    made = render_fhir(report, 1_790_000_000_000_000_000)
    Bundle.model_validate_json(made)
    assert made == render_fhir(report, 1_790_000_000_000_000_000)
    content = json.loads(made)
    known = [entry["fullUrl"] for entry in content["entry"]]
    assert len(known) == len(set(known))
    found = {value for value in _references(content) if value.startswith("urn:uuid:")}
    assert found <= set(known)
    kinds = {entry["resource"]["resourceType"] for entry in content["entry"]}
    assert kinds == {
        "Patient", "Procedure", "Observation", "DiagnosticReport", "Device", "Provenance", "CodeSystem"
    }  # fmt: skip
    assert "loinc" not in made.decode().lower()


def test_each_number_is_one_observation_with_a_ucum_unit_or_a_reason(report: Report) -> None:
    content = json.loads(render_fhir(report, 0))
    observations = [
        one["resource"] for one in content["entry"] if one["resource"]["resourceType"] == "Observation"
    ]
    metrics = [item for summary in report.summaries for item in summary.metrics]
    for item, one in zip(metrics, observations, strict=True):
        assert one["code"]["coding"][0]["code"] == item.name
        assert ("valueQuantity" in one) == item.measurable
        if item.measurable:
            assert one["valueQuantity"]["value"] == pytest.approx(item.value, abs=1e-12)
            assert one["valueQuantity"]["code"] == UCUM_OF[item.unit]
        else:
            assert item.status.endswith(one["dataAbsentReason"]["text"])


def test_every_unit_of_the_metrics_has_its_ucum_code() -> None:
    assert {item.unit for item in DEFINITIONS.values()} <= set(UCUM_OF)


def test_the_pdf_is_inside_the_bundle_and_the_patient_is_a_pseudonym(make_session: Make) -> None:
    alone = Report((measure(make_session()),), "0.1.0")
    resources = [entry["resource"] for entry in json.loads(render_fhir(alone, 0))["entry"]]
    told = next(one for one in resources if one["resourceType"] == "DiagnosticReport")
    assert base64.b64decode(told["presentedForm"][0]["data"]) == render_pdf(alone)
    patient = next(one for one in resources if one["resourceType"] == "Patient")
    assert patient["identifier"][0]["value"] == "P-0001"
    assert "name" not in patient


def test_the_note_is_short_and_says_what_must_stand_beside_a_number(report: Report) -> None:
    take, session = render_note(report).split("\n\n")
    assert "Range by virtual-camera" in take
    assert "Range by encoder (the robot moved the hand)" in session
    assert "Support: stiffness 0.90 Nm/rad" in session
    assert "The stop button was pressed." in session
    assert "Not a certified medical device." in session
    assert len(session.splitlines()) <= 12


def test_every_format_renders(report: Report) -> None:
    for made in FORMATS.values():
        assert made.render(report)


def _references(content: Any) -> list[str]:
    if isinstance(content, dict):
        own = [content["reference"]] if isinstance(content.get("reference"), str) else []
        return own + [one for value in content.values() for one in _references(value)]
    if isinstance(content, list):
        return [one for value in content for one in _references(value)]
    return []


def test_the_interval_is_a_pair_of_components(make_session: Make) -> None:
    alone = Report((measure(make_session()),), "0.1.0")
    item = alone.summaries[0].metric("joint_rmse", "index_pip")
    assert item is not None
    assert item.interval is not None
    found = [
        one["resource"]
        for one in json.loads(render_fhir(alone, 0))["entry"]
        if one["resource"].get("code", {}).get("text", "") == "Joint error, index pip"
    ]
    ends = [part["valueQuantity"]["value"] for part in found[0]["component"]]
    assert ends == pytest.approx(list(item.interval))
    assert all(math.isfinite(end) for end in ends)
