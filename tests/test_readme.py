"""The README's commands are run as they stand, in their order, in an empty folder."""

from __future__ import annotations

import shlex
import signal
from pathlib import Path

import pytest
from typer.testing import CliRunner

from rehab_app.cameras.sequence import point_sequence
from rehab_app.cameras.sequence_file import write_detections_npz
from rehab_app.cli.app import app

REPOSITORY = Path(__file__).resolve().parents[1]
FRAMES = 450
NOT_RUN = ("rehab-app serve",)  # runs until it is interrupted: the browser test serves a clinic


def commands() -> list[list[str]]:
    lines = (REPOSITORY / "README.md").read_text().splitlines()
    shown = [line.strip() for line in lines if line.startswith("    rehab-app ")]
    return [shlex.split(line, comments=True) for line in shown if not line.startswith(NOT_RUN)]


def short_recording(shared_data: Path) -> str:
    """The first seconds of the real recording, so that the test is over sooner."""
    lines = (shared_data / "mocap_hand_dfki" / "recording.tsv").read_text().splitlines(keepends=True)
    first = next(number for number, line in enumerate(lines) if line.startswith("Frame\t")) + 1
    header = [
        f"NO_OF_FRAMES\t{FRAMES}\n" if line.startswith("NO_OF_FRAMES") else line for line in lines[:first]
    ]
    return "".join(header + lines[first : first + FRAMES])


@pytest.fixture
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Where a user would stand; a command may not leave its signal handler behind in the tests."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("REHAB_DATA", str(tmp_path / "clinic"))
    before = signal.getsignal(signal.SIGINT)
    yield tmp_path
    signal.signal(signal.SIGINT, before)


def test_every_command_of_the_readme_works(empty_folder: Path, shared_data: Path) -> None:
    tmp_path = empty_folder
    (tmp_path / "recording.tsv").write_text(short_recording(shared_data))
    write_detections_npz(point_sequence("easy", 1, 90), tmp_path / "points.npz")
    found = commands()
    assert len(found) >= 8
    for words in found:
        done = CliRunner().invoke(app, words[1:], input="a long enough password\n")
        assert done.exit_code == 0, f"{' '.join(words)}: {done.output}"
    assert list((tmp_path / "report").glob("*.html"))
    assert (tmp_path / "session.mcap").is_file()
    assert (tmp_path / "tracks.npz").is_file()
