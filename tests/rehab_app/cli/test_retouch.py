"""Retouched takes through the real command line: a new take each time, with lineage, and never approved."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app


def invoke(data, *arguments):
    return CliRunner().invoke(app, [*(str(item) for item in arguments), "--data", str(data), "--json"])


def run(data, *arguments):
    result = invoke(data, *arguments)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return tmp_path_factory.mktemp("clinic")


@pytest.fixture(scope="module")
def take(data):
    made = run(data, "record", "--exercise", "open_close", "--seconds", "4", "--seed", "2")
    run(data, "approve", made["id"], "--by", "anna")
    return made


def test_each_retouch_is_a_take_of_its_own_with_a_parent(data, take):
    first = run(
        data, "retouch", take["id"], "--trim", "0.5:3.5", "--smooth", "30", "--reason", "late", "--by", "anna"
    )
    assert first["duration_s"] == pytest.approx(3.0, abs=0.1)
    assert (first["parent"], first["author"], first["reason"]) == (take["id"], "anna", "late")
    again = run(
        data, "retouch", first["id"], "--slow", "2", "--scale", "index=0.8", "--reason", "tight index"
    )
    assert again["parent"] == first["id"]
    assert again["duration_s"] > 1.5 * first["duration_s"]
    header = run(data, "info", again["take"])
    assert header["parents"] == [first["sha256"]]
    refused = invoke(data, "play", again["id"])
    assert refused.exit_code == 1
    assert "not approved" in json.loads(refused.stdout)["error"]["message"]


def test_parts_are_slowed_where_they_were_in_the_take(data, take):
    plain = run(data, "retouch", take["id"], "--slow", "3:2.5:3.5", "--reason", "fast end")
    both = run(
        data, "retouch", take["id"], "--slow", "2:0.5:1.5", "--slow", "3:2.5:3.5", "--reason", "two fast ends"
    )
    assert both["duration_s"] > plain["duration_s"] > take["duration_s"]


def test_a_copy_for_the_user_is_that_take(data, take, tmp_path):
    out = tmp_path / "copy.mcap"
    made = run(data, "retouch", take["id"], "--smooth", "50", "--reason", "x", "--out", out)
    assert run(data, "verify", out)["sha256"] == made["sha256"]


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--trim", "2"),
        ("--trim", "3:2"),
        ("--trim", "nan:2"),
        ("--trim", "0:99"),
        ("--smooth", "1"),
        ("--smooth", "nan"),
        ("--slow", "0.5"),
        ("--slow", "2:1"),
        ("--slow", "inf"),
        ("--slow", "x"),
        ("--scale", "toe=1"),
        ("--scale", "index"),
        ("--scale", "index=9"),
        ("--scale", "index=nan"),
    ],
)
def test_nonsense_is_refused_and_leaves_no_take(data, take, options):
    before = sorted((data / "takes").iterdir())
    result = invoke(data, "retouch", take["id"], *options, "--reason", "x")
    assert isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == 1
    assert json.loads(result.stdout)["error"]["remedy"]
    assert sorted((data / "takes").iterdir()) == before


def test_a_reason_and_a_take_are_needed(data, take):
    for take_id, reason in ((take["id"], " "), (take["id"], "x" * 501), ("ffffffff", "x")):
        result = invoke(data, "retouch", take_id, "--smooth", "50", "--reason", reason)
        assert result.exit_code == 1, result.output
