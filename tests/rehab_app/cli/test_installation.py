"""``config`` shows what holds and hides secrets; ``unit`` prints a unit that systemd takes, hardened."""

from __future__ import annotations

import configparser
import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app
from rehab_app.cli.doctor import examine
from rehab_app.cli.systemd_unit import unit_text
from rehab_app.config import KEYS, ClinicFolder
from rehab_app.errors import Refused

DEPLOYED = Path(__file__).parents[3] / "docs" / "deploy" / "rehab-app.service"
PYTHON = Path("/opt/rehab-app/bin/python")


def run(*words, **environment):
    return CliRunner().invoke(app, [str(word) for word in words], env=environment)


def sections(text):
    parser = configparser.RawConfigParser(strict=False)
    parser.optionxform = str
    parser.read_string(text)
    return parser


def test_config_shows_value_and_origin_and_no_secret(tmp_path):
    file = tmp_path / "rehab-app.toml"
    file.write_text("catalogue_url = 'postgresql://u:geheim@h/d'\n[server]\nport = 9000\n", encoding="utf-8")
    done = run("config", "--data", tmp_path, "--json", REHAB_STORE_SECRET_KEY="geheim")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["file"] == str(file)
    assert set(told["settings"]) == {key.dotted for key in KEYS}
    port = told["settings"]["server.port"]
    assert port == {"value": 9000, "origin": "rehab-app.toml:3", "variable": "REHAB_SERVER_PORT"}
    assert told["settings"]["store.secret_key"] == {
        "value": "(set)",
        "origin": "environment",
        "variable": "REHAB_STORE_SECRET_KEY",
    }
    assert "geheim" not in done.output


def test_the_option_before_the_command_names_the_file_for_that_command_only(tmp_path):
    other = tmp_path / "other.toml"
    other.write_text("station = 'room-7'\n", encoding="utf-8")
    done = run("--config", other, "config", "--data", tmp_path, "--json")
    assert json.loads(done.stdout)["settings"]["station"]["value"] == "room-7"
    assert "REHAB_CONFIG" not in os.environ
    again = run("config", "--data", tmp_path, "--json")
    assert json.loads(again.stdout)["settings"]["station"]["value"] == ""


def test_a_wrong_setting_is_one_sentence_before_anything_starts(tmp_path):
    (tmp_path / "rehab-app.toml").write_text("[server]\nprot = 1\n", encoding="utf-8")
    for words in (("serve",), ("user", "list"), ("config",)):
        done = run(*words, "--data", tmp_path)
        assert done.exit_code == 1
        assert "server.prot (rehab-app.toml:2) is unknown" in " ".join(done.output.split())
        assert "Traceback" not in done.output
    found = {one.name: one for one in examine(ClinicFolder(tmp_path), 0)}["settings"]
    assert not found.ok
    assert "rehab-app.toml:2" in found.found


def test_doctor_tells_of_a_secret_that_others_may_read(tmp_path):
    file = tmp_path / "rehab-app.toml"
    file.write_text("[metrics]\ntoken = 'x'\n", encoding="utf-8")
    for mode, well in ((0o644, False), (0o600, True)):
        file.chmod(mode)
        found = {one.name: one for one in examine(ClinicFolder(tmp_path), 0)}["settings"]
        assert found.ok == well
    assert "chmod 600" not in found.remedy


def test_a_demonstration_never_writes_into_the_clinics_own_catalogue(tmp_path, monkeypatch):
    def ends(*_):
        raise Refused("walk", "ended", "looked at", "go on")

    monkeypatch.setattr("rehab_app.services.walkthrough.walk", ends)
    own = tmp_path / "own.sqlite3"
    url = f"sqlite:///{own}"
    done = run("demo", "--headless", "--out", tmp_path / "demo", REHAB_CATALOGUE_URL=url)
    assert (done.exit_code, own.exists()) == (1, False), done.output
    assert "walk is ended" in done.output
    assert run("user", "list", "--data", tmp_path / "c", REHAB_CATALOGUE_URL=url).exit_code == 0
    assert own.exists()


def test_the_unit_is_hardened_and_restarts():
    service = sections(unit_text(python=PYTHON))["Service"]
    assert service["Type"] == "notify"
    assert service["Restart"] == "on-failure"
    assert int(service["WatchdogSec"]) > 0
    assert int(service["LimitRTPRIO"]) >= 10  # what the motion process asks for
    assert service["DynamicUser"] == service["NoNewPrivileges"] == service["PrivateTmp"] == "yes"
    assert service["ProtectSystem"] == "strict"
    assert service["StateDirectoryMode"] == "0700"
    assert service["CapabilityBoundingSet"] == ""
    assert service["UMask"] == "0077"
    assert service["ExecStart"] == f"{PYTHON} -m rehab_app serve"


def test_the_unit_in_the_documentation_is_the_one_that_is_printed():
    assert DEPLOYED.read_text(encoding="utf-8") == unit_text(python=PYTHON)


def test_the_unit_of_an_account_and_a_folder_that_exist(tmp_path):
    text = unit_text("clinic", Path("/srv/clinic"), PYTHON)
    service = sections(text)["Service"]
    assert (service["User"], service["ReadWritePaths"]) == ("clinic", "/srv/clinic")
    assert "REHAB_DATA=/srv/clinic\n" in text
    assert "DynamicUser" not in text
    assert sections(unit_text("", Path("/home/clinic/data"), PYTHON))["Service"]["ProtectHome"] == "read-only"


@pytest.mark.parametrize("bad", ["/srv/a b", "/srv/a\nExecStart=x", "/srv/%n", '/srv/"', "/srv/$HOME"])
def test_nothing_in_a_path_means_something_in_the_unit(bad):
    with pytest.raises(Refused):
        unit_text(data=Path(bad))
    with pytest.raises(Refused):
        unit_text(user="root\nUser=x")


def test_unit_is_printed():
    done = run("unit")
    assert done.exit_code == 0
    assert done.stdout == unit_text()
    assert json.loads(run("unit", "--json").stdout) == {"unit": unit_text()}


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed here")
def test_systemd_takes_the_unit_and_finds_it_hardened(tmp_path):
    file = tmp_path / "rehab-app.service"
    file.write_text(unit_text(), encoding="utf-8")
    taken = subprocess.run(["systemd-analyze", "verify", file], capture_output=True, text=True)
    assert "rehab-app.service" not in taken.stderr, taken.stderr
    words = ["systemd-analyze", "security", "--offline=true", "--threshold=25", "--no-pager", str(file)]
    looked = subprocess.run(words, capture_output=True, text=True)
    assert looked.returncode == 0, looked.stdout[-400:] + looked.stderr
