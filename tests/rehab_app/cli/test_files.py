"""info, verify, recover and the shape of every refusal, through the real command line."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app
from rehab_app.hand.subject import geometry_to_json
from robot_iface.kinematics import average_hand
from sessions.records import Event, SessionHeader
from sessions.records.topics import EVENTS
from sessions.store import SessionWriter


def run(*arguments, data=None, text=None):
    environment = {} if data is None else {"REHAB_DATA": str(data)}
    result = CliRunner().invoke(app, [str(item) for item in arguments], env=environment, input=text)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def refused(*arguments, data=None):
    """The error object of a refused command: exit 1, one JSON object, one sentence on stderr."""
    result = run(*arguments, "--json", data=data)
    assert result.exit_code == 1, result.output
    error = json.loads(result.stdout)["error"]
    assert set(error) == {"thing", "value", "bound", "remedy", "message"}
    assert "Traceback" not in result.output
    said = " ".join(result.stderr.split())
    assert said == " ".join(error["message"].split())
    return error


@pytest.fixture
def session(tmp_path):
    header = SessionHeader(
        session_id="0" * 32,
        kind="take",
        subject_id="therapist",
        side="right",
        exercise="open_close",
        source="test",
        software_version="0",
        utc_start_ns=1_700_000_000_000_000_000,
        monotonic_start_ns=0,
        subject_hand=geometry_to_json(average_hand()),
    )
    path = tmp_path / "walk.mcap"
    with SessionWriter(path, header) as writer:
        for second in range(3):
            writer.write(
                EVENTS,
                Event(
                    t_ns=second * 10**9,
                    kind="note",
                    severity="info",
                    cause="test",
                    category="",
                    subject="",
                    value=float("nan"),
                    bound=float("nan"),
                    text="a note",
                ),
            )
        writer.seal()
    return path


def test_info_says_what_is_in_a_file(session):
    content = json.loads(run("info", session, "--json").stdout)
    assert content["side"] == "right"
    assert content["duration_s"] == pytest.approx(2.0)
    assert content["topics"] == {"/events": 3}


def test_human_text_stays_off_stdout(session):
    result = run("info", session)
    assert result.stdout == ""
    assert "right hand" in result.stderr


def test_verify_proves_a_whole_file_and_refuses_a_changed_one(session):
    assert json.loads(run("verify", session, "--json").stdout)["ok"] is True
    content = bytearray(session.read_bytes())
    content[len(content) // 3] ^= 1
    session.write_bytes(content)
    assert session.name in refused("verify", session)["thing"]


def test_a_cut_file_offers_recover_which_restores_it(session, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(session.read_bytes()[:-200])
    assert "rehab-app recover" in refused("info", cut)["remedy"]
    restored = json.loads(run("recover", cut, "--out", tmp_path / "whole.mcap", "--json").stdout)
    assert restored["records"] == 3
    assert json.loads(run("verify", restored["path"], "--json").stdout)["ok"] is True


@pytest.mark.parametrize("content", [b"", b"not an mcap at all", b"\x89MCAP0\r\n", bytes(4096)])
@pytest.mark.parametrize("command", ["info", "verify", "report"])
def test_what_is_no_session_is_refused(tmp_path, content, command):
    path = tmp_path / "odd.mcap"
    path.write_bytes(content)
    before = sorted(tmp_path.rglob("*"))
    error = refused(
        command,
        path,
        *(("--out", tmp_path / "made") if command == "report" else ()),
        data=tmp_path.parent / f"{tmp_path.name}-clinic",
    )
    assert "odd.mcap" in error["thing"]
    assert sorted(tmp_path.rglob("*")) == before


def test_a_foreign_file_is_told_from_ours(shared_data):
    for path in sorted((shared_data / "foreign_mcap").glob("*.mcap")):
        error = refused("info", path)
        assert path.name in error["thing"]
        assert error["remedy"]


def test_an_unknown_id_is_refused(tmp_path):
    assert "deadbeef" in refused("info", "deadbeef", data=tmp_path)["thing"]


def test_wrong_usage_is_2():
    assert run("info").exit_code == 2
    assert run("fly").exit_code == 2


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path):
    in_the_way = tmp_path / "clinic"
    in_the_way.write_text("")
    assert "--data" in refused("patient", "list", data=in_the_way)["remedy"]


def test_patients_and_users_from_the_command_line(tmp_path):
    added = json.loads(
        run(
            *("patient", "add", "--given", "Ada", "--family", "L", "--birth-date", "1950-12-31"),
            *("--side", "left", "--json"),
            data=tmp_path,
        ).stdout
    )
    listed = json.loads(run("patient", "list", "--json", data=tmp_path).stdout)
    assert [row["id"] for row in listed["patients"]] == [added["id"]]
    made = run("user", "add", "anna", "--json", data=tmp_path, text="correct horse battery\n")
    assert json.loads(made.stdout) == {"name": "anna", "role": "therapist", "patient": ""}
    assert json.loads(run("user", "list", "--json", data=tmp_path).stdout)["users"] == [
        {"name": "anna", "role": "therapist", "patient": ""}
    ]
    short = run("user", "add", "bert", "--json", data=tmp_path, text="short\n")
    assert short.exit_code == 1
    assert "10 to 200" in json.loads(short.stdout)["error"]["bound"]


def test_an_interrupt_is_one_sentence(monkeypatch, tmp_path):
    def interrupted(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("sessions.store.info", interrupted)
    assert "interrupted" in refused("info", tmp_path / "some.mcap")["value"]


def test_a_full_disk_is_one_sentence(monkeypatch, tmp_path):
    def full(*_args, **_kwargs):
        raise OSError(28, "No space left on device", "some.mcap")

    monkeypatch.setattr("sessions.store.info", full)
    assert "No space left" in refused("info", tmp_path / "some.mcap")["value"]


def test_figures_are_si_and_finite(session):
    content = json.loads(run("info", session, "--json").stdout)
    assert np.isfinite(content["duration_s"])
