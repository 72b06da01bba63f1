"""Kills migration, backup, restoring and erasure at random moments: the next try goes on, nothing is harmed.

``python -m tests.bench.durability.acts --kills 100`` kills each act so often; the suite does it a few times.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import signal
import sqlite3
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from alembic import command
from alembic.config import Config
from sqlalchemy import create_engine

import sessions.catalogue
from rehab_app.access import CONSOLE
from rehab_app.config import ClinicFolder
from rehab_app.services.audit import Audit
from rehab_app.services.backup import Backups
from rehab_app.services.erasure import Erasures
from rehab_app.services.restoring import restore
from sessions.catalogue import Catalogue, Patient, TherapySession
from sessions.store import SessionWriter, verify

from .recording import header, name_of, record_rows

PASSPHRASE = "a long sentence for the safe"
SESSIONS = 8


@dataclass(frozen=True, slots=True)
class Act:
    """Something that may be killed.

    Attributes:
        name: What it is called in figures.
        prepare: Makes the place in which it acts out of the pattern of a clinic.
        do: Does it.
        check: Proves, after a kill or an end, that nothing is harmed and that the next try ends well.
    """

    name: str
    prepare: Callable[[Path, Path], None]
    do: Callable[[Path], None]
    check: Callable[[Path, Path], None]


def make_pattern(folder: Path) -> None:
    """A clinic with two patients, sealed sessions of both, and a passphrase for backups."""
    place = ClinicFolder(folder).create()
    with Catalogue.open(folder) as catalogue:
        people = [
            catalogue.add_patient(
                Patient(given_name=name, family_name="Nowhere", birth_date="1950-01-01", side="left")
            )
            for name in ("Ada", "Bruno")
        ]
        for number in range(SESSIONS):
            path = name_of(place.sessions, number)
            with SessionWriter(path, header(number)) as writer:
                record_rows(writer, number, range(400))
                sealed = writer.seal()
            catalogue.add_session(
                TherapySession(
                    patient=people[number % 2].id,
                    take="",
                    sha256=sealed.sha256,
                    path=path.relative_to(folder).as_posix(),
                    mode="passive",
                    started_utc_ns=10**18 + number,
                )
            )
        _backups(place, catalogue).set_passphrase(CONSOLE, PASSPHRASE)


def campaign(kills: int, seed: int, folder: Path) -> dict[str, int]:
    """Kill every act so often, and say how many of the kills came in time.

    Args:
        kills: Kills of each act.
        seed: Of the moments.
        folder: An empty folder to work in.

    Raises:
        AssertionError: Something was harmed, or a next try did not go on.
    """
    pattern, rng = folder / "pattern", np.random.default_rng(seed)
    make_pattern(pattern)
    figures: dict[str, int] = {}
    for act in ACTS:
        place = folder / "place"
        whole_s = _duration_s(act, pattern, place)
        in_time = 0
        for _ in range(kills):
            _prepare(act, pattern, place)
            in_time += _killed(act, place, float(rng.uniform(0.0, whole_s)))
            act.check(pattern, place)
        figures[act.name] = in_time
    return figures


def _prepare(act: Act, pattern: Path, place: Path) -> None:
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    act.prepare(pattern, place)


def _duration_s(act: Act, pattern: Path, place: Path) -> float:
    _prepare(act, pattern, place)
    begun_s = time.monotonic()
    assert not _killed(act, place, 60.0)
    whole_s = time.monotonic() - begun_s
    act.check(pattern, place)
    return whole_s


def _killed(act: Act, place: Path, after_s: float) -> bool:
    """Do it in a child that is killed after a time; whether the kill came before the end."""
    child = os.fork()
    if child == 0:
        try:
            act.do(place)
            os._exit(0)
        except Exception:
            traceback.print_exc()
            raise
        finally:
            os._exit(1)
    end_s = time.monotonic() + after_s
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            assert os.waitstatus_to_exitcode(status) == 0, f"{act.name} failed by itself"
            return False
        if time.monotonic() >= end_s:
            os.kill(child, signal.SIGKILL)
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0
        time.sleep(0.0005)


def _backups(place: ClinicFolder, catalogue: Catalogue) -> Backups:
    return Backups(place, catalogue, Audit(catalogue), "0")


def _clinic_whole(pattern: Path, root: Path, without: str = "") -> None:
    """The clinic opens, its audit chain holds, and every sealed file is what it was."""
    with Catalogue.open(root) as catalogue:
        catalogue.verify_audit()
        rows = catalogue.sessions()
    wanted = sorted(path.name for path in (pattern / "sessions").glob("*.mcap"))
    assert len(rows) == (SESSIONS // 2 if without else SESSIONS)
    for row in rows:
        assert row.patient != without
        assert verify(root / row.path).sha256 == row.sha256
        assert Path(row.path).name in wanted


# --- migration


def _old_data_base(pattern: Path, place: Path) -> None:
    config = Config()
    config.set_main_option("script_location", str(Path(sessions.catalogue.__path__[0]) / "migrations"))
    engine = create_engine(f"sqlite:///{place / 'clinic.sqlite3'}")
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, "0001")
    engine.dispose()
    with sqlite3.connect(place / "clinic.sqlite3") as connection:
        connection.executemany(
            "INSERT INTO patients VALUES (?, ?, '', '', '', 'left', 0.18, '', 0, 5)",
            [(number, f"P-{number:04d}") for number in range(1, 400)],
        )
    connection.close()


def _migrate(place: Path) -> None:
    Catalogue.open(place).close()


def _migrated(pattern: Path, place: Path) -> None:
    with Catalogue.open(place) as catalogue:
        assert len(catalogue.patients()) == 399


# --- backup


def _copy(pattern: Path, place: Path) -> None:
    shutil.copytree(pattern, place / "clinic")


def _back_up(place: Path) -> None:
    folder = ClinicFolder(place / "clinic")
    with Catalogue.open(folder.root) as catalogue:
        _backups(folder, catalogue).make(CONSOLE, place / "new.rehab-backup")


def _backed_up(pattern: Path, place: Path) -> None:
    _clinic_whole(pattern, place / "clinic")
    target = place / "new.rehab-backup"
    if not target.exists():  # absent, never half
        _back_up(place)
    restore(target, ClinicFolder(place / "restored"), PASSPHRASE)
    _clinic_whole(pattern, place / "restored")


# --- restoring


def _saved(pattern: Path, place: Path) -> None:
    kept = pattern.with_name("kept.rehab-backup")
    if not kept.exists():
        folder = ClinicFolder(pattern)
        with Catalogue.open(pattern) as catalogue:
            _backups(folder, catalogue).make(CONSOLE, kept)
    shutil.copy(kept, place / "kept.rehab-backup")


def _restore(place: Path) -> None:
    restore(place / "kept.rehab-backup", ClinicFolder(place / "clinic"), PASSPHRASE)


def _restored(pattern: Path, place: Path) -> None:
    digest = hashlib.sha256((place / "kept.rehab-backup").read_bytes()).digest()
    assert digest == hashlib.sha256(pattern.with_name("kept.rehab-backup").read_bytes()).digest()
    if not (place / "clinic").exists() or not any((place / "clinic").iterdir()):
        _restore(place)
    _clinic_whole(pattern, place / "clinic")


# --- erasure


def _erase(place: Path) -> None:
    folder = ClinicFolder(place / "clinic")
    with Catalogue.open(folder.root) as catalogue:
        Erasures(folder, catalogue, Audit(catalogue)).erase(CONSOLE, "P-0001", "P-0001")


def _erased(pattern: Path, place: Path) -> None:
    folder = ClinicFolder(place / "clinic")
    with Catalogue.open(folder.root) as catalogue:
        Erasures(folder, catalogue, Audit(catalogue)).finish()  # as every start does
        known = any(patient.id == "P-0001" for patient in catalogue.patients())
    if known:  # killed before the act: nothing is lost, and it can be done
        _clinic_whole(pattern, folder.root)
        _erase(place)
    _clinic_whole(pattern, folder.root, without="P-0001")
    assert len(list(folder.sessions.glob("*.mcap"))) == SESSIONS // 2


ACTS = (
    Act("migration", _old_data_base, _migrate, _migrated),
    Act("backup", _copy, _back_up, _backed_up),
    Act("restoring", _saved, _restore, _restored),
    Act("erasure", _copy, _erase, _erased),
)


def main() -> None:
    """Run a campaign and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    begun_s = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        figures = campaign(chosen.kills, chosen.seed, Path(folder))
    sys.stdout.write(json.dumps(figures | {"wall_s": round(time.monotonic() - begun_s, 1)}) + "\n")


if __name__ == "__main__":
    main()
