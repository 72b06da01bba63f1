from __future__ import annotations

import stat
from pathlib import Path

import pytest

from rehab_app.config import ClinicFolder, resolve_folder
from rehab_app.errors import Refused


def test_the_option_goes_before_the_environment_before_the_users_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("REHAB_DATA", str(tmp_path / "environment"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    assert resolve_folder(tmp_path / "option").root == tmp_path / "option"
    assert resolve_folder().root == tmp_path / "environment"
    monkeypatch.delenv("REHAB_DATA")
    assert resolve_folder().root == tmp_path / "share" / "rehab-app"
    monkeypatch.delenv("XDG_DATA_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert resolve_folder().root == tmp_path / "home" / ".local" / "share" / "rehab-app"


def test_a_clinic_folder_is_private(tmp_path):
    folder = ClinicFolder(tmp_path / "clinic").create()
    for room in (folder.root, folder.takes, folder.sessions, folder.reports):
        assert stat.S_IMODE(room.stat().st_mode) == 0o700
    folder.create()


def test_a_file_in_the_way_is_refused(tmp_path):
    in_the_way = tmp_path / "clinic"
    in_the_way.write_text("")
    with pytest.raises(Refused, match="--data or REHAB_DATA"):
        ClinicFolder(in_the_way).create()


def test_a_relative_folder_becomes_absolute(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert resolve_folder(Path("clinic")).root == tmp_path / "clinic"
