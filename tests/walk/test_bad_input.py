"""Everything that a user can get wrong ends in one sentence, exit code 1, and no file."""

from __future__ import annotations

import json
import shutil
import socket

import numpy as np
import pytest
from typer.testing import CliRunner

from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app


def refused(data, *arguments):
    """The error object; nothing but the data base may have changed in the clinic folder."""
    before = files(data)
    arguments = [*(str(item) for item in arguments), "--data", str(data), "--json"]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == 1, result.output
    assert "Traceback" not in result.output
    error = json.loads(result.stdout)["error"]
    assert all(error[key] for key in ("thing", "value", "bound", "remedy"))
    assert error["message"].count("\n") == 0
    assert files(data) == before
    return error


def files(data):
    return sorted(path for path in data.rglob("*") if path.is_file() and "sqlite" not in path.name)


def run(data, *arguments):
    result = CliRunner().invoke(app, [*(str(item) for item in arguments), "--data", str(data), "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clinic")
    with open_clinic(folder):
        pass
    return folder


@pytest.fixture(scope="module")
def take(data):
    return run(data, "record", "--exercise", "pinch", "--seconds", "3", "--seed", "2")["take"]


TSV = "NO_OF_FRAMES\t{frames}\nNO_OF_MARKERS\t2\nFREQUENCY\t100\nMARKER_NAMES\t{names}\n{rows}\n"


def test_a_file_that_is_no_mcap(data, tmp_path):
    for content in (b"", b"hello", bytes(1000)):
        path = tmp_path / "odd.mcap"
        path.write_bytes(content)
        for command in (("info",), ("verify",), ("report",), ("approve", "--by", "anna"), ("play",)):
            refused(data, command[0], path, *command[1:])


def test_a_file_that_is_not_there(data, tmp_path):
    for command in (("info",), ("report",), ("play",), ("import",), ("recover",)):
        arguments = (*command, tmp_path / "nowhere.mcap")
        if command == ("recover",):
            result = CliRunner().invoke(app, [*(str(item) for item in arguments), "--json"])
            assert result.exit_code == 1
        else:
            refused(data, *arguments)


def test_a_cut_take_offers_recover(data, take, tmp_path):
    cut = tmp_path / "cut.mcap"
    with open(take, "rb") as file:
        cut.write_bytes(file.read()[:-100])
    assert "recover" in refused(data, "play", cut)["remedy"]


def test_every_foreign_file_is_named_for_what_it_is(data, shared_data):
    for path in sorted((shared_data / "foreign_mcap").glob("*.mcap")):
        assert path.name in refused(data, "report", path)["thing"]


def test_a_tsv_without_hand_markers(data, tmp_path):
    path = tmp_path / "legs.tsv"
    rows = "\n".join("\t".join(["1.0"] * 6) for _ in range(200))
    path.write_text(TSV.format(frames=200, names="knee\tankle", rows=rows))
    refused(data, "import", path)


def test_columns_of_nothing(data, tmp_path):
    path = tmp_path / "nothing.npz"
    np.savez(path, landmarks_m=np.full((90, 21, 3), np.nan), fps=30)
    refused(data, "import", path)


def test_a_take_shorter_than_a_second(data, tmp_path):
    path = tmp_path / "short.npz"
    np.savez(path, landmarks_m=np.random.default_rng(1).normal(size=(20, 21, 3)), fps=30)
    assert "1 s" in refused(data, "import", path)["bound"]
    refused(data, "record", "--seconds", "0.5")


@pytest.mark.parametrize("suffix", [".tsv", ".npz", ".bvh"])
def test_random_bytes_are_no_recording(data, tmp_path, suffix):
    path = tmp_path / f"random{suffix}"
    path.write_bytes(np.random.default_rng(3).bytes(5000))
    refused(data, "import", path)


def test_an_unapproved_take(data, take):
    assert "approve" in refused(data, "play", take)["remedy"]


def test_an_unknown_patient_side_mode_twin_or_robot(data, take):
    run(data, "approve", take, "--by", "anna")
    for option in (
        ("--patient", "P-9999"),
        ("--mode", "dance"),
        ("--virtual-patient", "zombie"),
        ("--robot", "toaster"),
        ("--robot", "ros2:nobody"),
        ("--space", "outer"),
        ("--warm-up", "-1"),
        ("--minutes", "nan"),
        ("--resistance", "2"),
        ("--hold-s", "inf"),
        ("--wrist-deg", "nan"),
        ("--seed", "-1"),
        ("--speed", "7"),
        ("--speed", "nan"),
        ("--repetitions", "0"),
        ("--stiffness", "100"),
    ):
        refused(data, "play", take, *option)
        refused(data, "rehearse", take, *option)
    refused(data, "record", "--side", "both")
    refused(data, "record", "--exercise", "juggling")


def test_an_out_that_cannot_be(data, take, tmp_path):
    there = tmp_path / "there.mcap"
    there.write_text("precious")
    for out in (there, tmp_path / "nowhere" / "out.mcap", tmp_path / "out.txt"):
        refused(data, "play", take, "--out", out)
        refused(data, "record", "--out", out)
    assert there.read_text() == "precious"


def test_a_port_in_use_and_a_second_server(data):
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        port = holder.getsockname()[1]
        result = CliRunner().invoke(app, ["serve", "--port", str(port), "--data", str(data)])
        assert result.exit_code == 1
        assert "in use" in " ".join(result.stderr.split())
    with open_clinic(data, serving=True):
        result = CliRunner().invoke(app, ["serve", "--port", str(port), "--data", str(data)])
        assert result.exit_code == 1
        assert "served by process" in " ".join(result.stderr.split())


def test_a_demo_of_no_length(data):
    assert "1 to 3600 s" in refused(data, "demo", "--headless", "--seconds", "0")["bound"]


def test_an_altered_take_after_its_approval(data, tmp_path):
    own = tmp_path / "clinic"
    shutil.copytree(data, own)
    with open_clinic(own) as clinic:
        (kept,) = clinic.takes.list()
    kept.path.write_bytes(kept.path.read_bytes() + b"x")
    refused(own, "play", kept.id)
