from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app
from rehab_app.vision.markerless.networks import NETWORKS

LIST = ["camera", "models", "list", "--json"]
INSTALL = ["camera", "models", "install", "--json"]


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "rehab-app" / "models"


def test_what_is_missing_is_listed_as_missing(cache: Path) -> None:
    done = CliRunner().invoke(app, LIST)
    assert done.exit_code == 0
    told = json.loads(done.stdout)
    assert told["folder"] == str(cache)
    assert [(row["file"], row["installed"]) for row in told["models"]] == [
        (network.file, False) for network in NETWORKS
    ]
    assert "run rehab-app camera models install" in done.stderr
    assert not cache.exists()


def test_networks_are_installed_from_files(networks: Path, cache: Path) -> None:
    for index, network in enumerate(NETWORKS):
        done = CliRunner().invoke(app, [*INSTALL, "--from", str(networks / network.file)])
        assert (done.exit_code, json.loads(done.stdout)["fresh"]) == (0, [network.file])
        installed = [row["installed"] for row in json.loads(CliRunner().invoke(app, LIST).stdout)["models"]]
        assert installed == [place <= index for place in range(len(NETWORKS))]
    again = CliRunner().invoke(app, INSTALL)
    assert (again.exit_code, json.loads(again.stdout)["fresh"]) == (0, [])


def test_another_file_is_refused_in_one_sentence(cache: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.whl"
    other.write_bytes(b"no archive")
    done = CliRunner().invoke(app, [*INSTALL, "--from", str(other)])
    assert done.exit_code == 1
    assert "other.whl is no wheel" in json.loads(done.stdout)["error"]["message"]
    assert not cache.exists()
