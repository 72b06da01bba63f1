"""A backup brings back every byte or nothing, opens with its passphrase only, and knows who was erased."""

from __future__ import annotations

import io
import resource
import shutil
import signal
import zipfile

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import age, backup_archive, storage
from rehab_app.services.erased_ledger import LEDGER
from rehab_app.services.restoring import restore

PASSPHRASE = "a long sentence for the safe"


@pytest.fixture(scope="module")
def clinic(tmp_path_factory, take_file):
    with open_clinic(tmp_path_factory.mktemp("place") / "clinic") as opened:
        opened.patients.add(
            CONSOLE, given_name="Ada", family_name="Nowhere", birth_date="1950-01-01", side="left"
        )
        opened.takes.get(take_file)
        opened.privacy.backups.set_passphrase(CONSOLE, PASSPHRASE)
        (opened.folder / "sessions" / "now.partial.mcap").write_bytes(b"being recorded")
        yield opened


@pytest.fixture(scope="module")
def saved(clinic, tmp_path_factory):
    target = tmp_path_factory.mktemp("disk") / "clinic.rehab-backup"
    clinic.privacy.backups.make(CONSOLE, target)
    return target


@pytest.fixture
def unlocked(monkeypatch, saved):
    """The passphrase's slow half is done once; what follows it is tried for each damage."""
    with zipfile.ZipFile(saved) as archive:
        identity = _identity(archive.read(backup_archive.KEY))
    monkeypatch.setattr(backup_archive, "unlock", lambda locked, passphrase: identity)


_kept: dict[bytes, str] = {}


def _identity(locked):
    if locked not in _kept:
        _kept[locked] = age.unlock(locked, PASSPHRASE)
    return _kept[locked]


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): storage.digest(path)
        for path in folder.rglob("*")
        if path.is_file() and "sqlite" not in path.name and path.name != "server.lock"
    }


def test_a_restored_clinic_is_the_same_byte_for_byte(clinic, saved, tmp_path):
    made = restore(saved, ClinicFolder(tmp_path / "new"), PASSPHRASE)
    before = contents(clinic.folder)
    assert before.pop("sessions/now.partial.mcap")
    assert contents(tmp_path / "new") == before
    assert made.manifest.sha256.keys() == {*before, "clinic.sqlite3"}
    assert made.erased_again == ()
    with open_clinic(tmp_path / "new") as again:
        assert again.patients.list() == clinic.patients.list()
        assert again.catalogue.takes() == clinic.catalogue.takes()
    assert list(tmp_path.iterdir()) == [tmp_path / "new"]


def test_no_byte_of_a_name_or_of_a_take_can_be_read_in_it(clinic, saved):
    raw = saved.read_bytes()
    assert b"Nowhere" not in raw
    assert b"MCAP" not in raw
    assert b"SQLite" not in raw
    assert saved.stat().st_mode & 0o077 == 0


def test_another_passphrase_opens_nothing(saved, tmp_path):
    with pytest.raises(Refused, match="backup passphrase is wrong"):
        restore(saved, ClinicFolder(tmp_path / "new"), PASSPHRASE + "!")
    assert list(tmp_path.iterdir()) == []


def _cut(raw):
    return raw[: len(raw) // 2]


def _altered(raw):
    place = len(raw) // 2
    return raw[:place] + bytes([raw[place] ^ 1]) + raw[place + 1 :]


def _without_content(raw):
    kept = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(raw)) as old, zipfile.ZipFile(kept, "w") as new:
        new.writestr(backup_archive.KEY, old.read(backup_archive.KEY))
    return kept.getvalue()


def _cut_inside(raw):
    """A well-formed zip whose encrypted content ends early."""
    kept = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(raw)) as old, zipfile.ZipFile(kept, "w") as new:
        new.writestr(backup_archive.KEY, old.read(backup_archive.KEY))
        new.writestr(backup_archive.CONTENT, old.read(backup_archive.CONTENT)[:-70_000])
    return kept.getvalue()


@pytest.mark.usefixtures("unlocked")
@pytest.mark.parametrize(
    "harm", [_cut, _altered, _without_content, _cut_inside, lambda raw: b"", lambda raw: b"no backup"]
)
def test_a_harmed_backup_restores_nothing(saved, tmp_path, harm):
    harmed = tmp_path / "harmed.rehab-backup"
    harmed.write_bytes(harm(saved.read_bytes()))
    with pytest.raises(Refused, match="nothing was restored"):
        restore(harmed, ClinicFolder(tmp_path / "new"), PASSPHRASE)
    assert list(tmp_path.iterdir()) == [harmed]


@pytest.mark.usefixtures("unlocked")
def test_a_name_that_leaves_the_folder_is_refused(clinic, tmp_path):
    outside = tmp_path / "secret.txt"
    outside.write_text("x")
    target = tmp_path / "evil.rehab-backup"
    key = clinic.privacy.backups.key()
    assert key is not None
    with target.open("wb") as file:
        parts = iter([backup_archive.Part("../escaped.txt", outside)])
        backup_archive.write_archive(file, parts, key, "0", 0)
    with pytest.raises(Refused, match="nothing was restored"):
        restore(target, ClinicFolder(tmp_path / "new"), PASSPHRASE)
    assert not (tmp_path / "escaped.txt").exists()


def test_a_folder_that_holds_something_is_left_alone(saved, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(Refused, match="not empty"):
        restore(saved, ClinicFolder(tmp_path), PASSPHRASE)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.usefixtures("unlocked")
def test_who_was_erased_since_is_erased_again(saved, take_file, tmp_path):
    target = tmp_path / "a" / "b.rehab-backup"
    with open_clinic(tmp_path / "clinic") as clinic:
        for name in ("Gone", "Stays"):
            clinic.patients.add(
                CONSOLE, given_name="A", family_name=name, birth_date="1950-01-01", side="left"
            )
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(age, "lock", lambda text, passphrase: text.encode())
            clinic.privacy.backups.set_passphrase(CONSOLE, PASSPHRASE)
        target.parent.mkdir()
        clinic.privacy.backups.make(CONSOLE, target)
        clinic.privacy.erasures.erase(CONSOLE, "P-0001", "P-0001")
        clinic.privacy.backups.make(CONSOLE, tmp_path / "a" / "later.rehab-backup")
    with zipfile.ZipFile(target) as archive, pytest.MonkeyPatch.context() as patch:
        identity = archive.read(backup_archive.KEY).decode()
        patch.setattr(backup_archive, "unlock", lambda locked, passphrase: identity)
        made = restore(target, ClinicFolder(tmp_path / "again"), PASSPHRASE)
    assert (target.parent / LEDGER).exists()
    assert made.erased_again == ("P-0001",)
    with open_clinic(tmp_path / "again") as clinic:
        assert [one.family_name for one in clinic.patients.list()] == ["Stays"]


@pytest.mark.parametrize(
    ("place", "sentence"),
    [
        ("clinic/inside.rehab-backup", "inside the clinic folder"),
        ("nowhere/x", "not there"),
        ("there", "new"),
    ],
)
def test_a_place_that_cannot_be_is_a_sentence(clinic, tmp_path, place, sentence):
    (tmp_path / "there").write_text("")
    target = clinic.folder.parent / place if place.startswith("clinic/") else tmp_path / place
    with pytest.raises(Refused, match=sentence):
        clinic.privacy.backups.make(CONSOLE, target)


def test_a_full_disk_leaves_no_half_file(clinic, tmp_path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    heard = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    (clinic.folder / "reports" / "large.html").write_bytes(b"0" * 4_000_000)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, before[1]))
    try:
        with pytest.raises(Refused, match="not written"):
            clinic.privacy.backups.make(CONSOLE, tmp_path / "x.rehab-backup")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, heard)
        (clinic.folder / "reports" / "large.html").unlink()
    assert list(tmp_path.iterdir()) == []


def test_only_who_may_back_up_does(clinic, tmp_path):
    therapist = Account("t", "therapist", "2")
    with pytest.raises(Refused, match="may not backup"):
        clinic.privacy.backups.make(therapist, tmp_path / "x.rehab-backup")
    with pytest.raises(Refused, match="may not backup"):
        clinic.privacy.backups.set_passphrase(therapist, PASSPHRASE)
    with pytest.raises(Refused, match="5 characters long"):
        clinic.privacy.backups.set_passphrase(CONSOLE, "short")


def test_stored_backups_are_listed_and_restored_beside(clinic, tmp_path, saved, monkeypatch):
    place = clinic.privacy.place
    place.set_place(CONSOLE, tmp_path / "store")
    made = place.make_stored(CONSOLE)
    assert place.stored() == (made,)
    with zipfile.ZipFile(made) as archive:
        identity = _identity(archive.read(backup_archive.KEY))
    monkeypatch.setattr(backup_archive, "unlock", lambda locked, passphrase: identity)
    restored = place.restore_beside(CONSOLE, made.name, PASSPHRASE)
    assert restored.folder.parent == clinic.folder.parent
    shutil.rmtree(restored.folder)
    with pytest.raises(Refused, match="unknown"):
        place.restore_beside(CONSOLE, "../../etc/passwd", PASSPHRASE)
    with pytest.raises(Refused, match="outside the clinic folder"):
        place.set_place(CONSOLE, clinic.folder / "b")
