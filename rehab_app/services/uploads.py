"""Sealed files of a clinic in its object store: sent, proven, erased, taken off the disk and brought back."""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder, StoreSettings, secret_key
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.object_queue import Errand, ErrandQueue, Kind, StoredMarks
from rehab_app.services.object_rooms import Sealed, sealed_files, sealed_named
from sessions.catalogue import Catalogue
from sessions.store import SessionReader
from sessions.store.object_source import fetch_object, open_object
from sessions.store.object_store import ObjectPlace, ObjectStore
from sessions.store.object_trouble import Absent, Unreachable

_DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class Pushed:
    """What one pass did.

    Attributes:
        sent: Files that now lie in the store, proven.
        deleted: Objects that were deleted.
        waiting: Errands that are left.
        refused: Sentences about single files that could not be sent.
    """

    sent: int
    deleted: int
    waiting: int
    refused: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StoreStatus:
    """How things stand.

    Attributes:
        bucket: Bucket, "" where recordings stay in the clinic folder only.
        to_send: Files that wait.
        to_delete: Deletions that wait.
        stored: Files that were proven to lie in the store.
        trouble: Why the last pass did not finish, "" where it did.
    """

    bucket: str
    to_send: int
    to_delete: int
    stored: int
    trouble: str


class Uploads:
    """The object store of a clinic.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        audit: Where files that leave the disk are noted.
        settings: The bucket and how it is reached.
        clock_s: UTC in seconds.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        catalogue: Catalogue,
        audit: Audit,
        settings: StoreSettings,
        clock_s: Callable[[], float] = time.time,
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit
        self._settings = settings
        self._clock_s = clock_s
        self._queue = ErrandQueue(folder.root)
        self._marks = StoredMarks(folder.root)
        self._seen: set[Path] = set()
        self._open_store: ObjectStore | None = None

    @property
    def configured(self) -> bool:
        """Whether there is an object store."""
        return bool(self._settings.bucket)

    def waiting(self) -> int:
        """How many errands wait."""
        return len(self._queue.waiting())

    def status(self) -> StoreStatus:
        """How things stand, without asking the store."""
        errands = self._queue.waiting()
        deletions = sum(errand.act == "delete" for errand in errands)
        to_send = len(errands) - deletions
        return StoreStatus(self._settings.bucket, to_send, deletions, len(self._marks), self._trouble_kept())

    def gather(self) -> int:
        """Queue every sealed file of the catalogue that the store has not; how many were added.

        Nothing is lost when a process ends between sealing and queuing: the next call finds the file.

        Raises:
            OSError: The disk refuses.
        """
        if not self.configured:
            return 0
        added = 0
        for found in sealed_files(self._folder, self._catalogue, self._seen):
            known = self._marks.has(found.kind, found.sha256)
            put, delete = found.errand("put"), found.errand("delete")
            if not known and not self._queue.holds(put) and not self._queue.holds(delete):
                self._queue.add(put)
                added += 1
            self._seen.add(found.path)
        return added

    def push(self, actor: Account) -> Pushed:
        """Work every errand off, once.

        Args:
            actor: Who asks (verb "backup").

        Returns:
            What was done; a file that is altered or gone is named and does not hold up the others.

        Raises:
            Unreachable: The store does not answer or does not allow it; everything left is kept.
            Refused: The actor may not, there is no store, or another process is at it.
        """
        require(actor, "backup")
        store = self._store()
        with self._alone():
            self.gather()
            try:
                done = self._worked_off(store)
            except Refused as refusal:
                self._keep_trouble(str(refusal))
                raise
            self._keep_trouble(" ".join(done.refused))
        return done

    def withdraw(self, kind: Kind, sha256: str) -> None:
        """A patient was erased: whatever the store holds of this file will be deleted.

        Args:
            kind: Room that the file lay in.
            sha256: Its digest.

        Raises:
            OSError: The disk refuses.
        """
        if self.configured or self._marks.has(kind, sha256):
            self._queue.add(Errand("delete", kind, sha256))
        self._queue.remove(Errand("put", kind, sha256))

    def evict(self, actor: Account, older_than_days: float) -> tuple[str, ...]:
        """Take files off the disk whose objects are proven now, once more; their digests stay.

        Args:
            actor: Who does it (verb "backup").
            older_than_days: Only files that were written longer ago.

        Returns:
            Paths that are gone, relative to the clinic folder.

        Raises:
            Refused: The actor may not, or the store does not answer or holds other bytes.
        """
        require(actor, "backup")
        store, gone = self._store(), list[str]()
        before_s = self._clock_s() - older_than_days * _DAY_S
        with self._alone():
            for found in sealed_files(self._folder, self._catalogue, frozenset()):
                state = found.path.stat()
                if state.st_mtime > before_s or not self._marks.has(found.kind, found.sha256):
                    continue
                store.prove(store.place.key(found.kind, found.sha256), found.sha256, state.st_size)
                found.path.unlink()
                self._seen.discard(found.path)
                gone.append(found.relative(self._folder.root))
        if gone:
            self._audit.note(actor, "store evict", "", f"{len(gone)} files")
        return tuple(gone)

    def fetch(self, actor: Account, named: str) -> Path:
        """Bring a file back whole and proven, where it is not here.

        Args:
            actor: Who asks (verb "view").
            named: Catalogue id of a session or take.

        Raises:
            Refused: The actor may not, it is unknown, or the store has not its bytes.
        """
        require(actor, "view")
        found = sealed_named(self._folder, self._catalogue, named)
        self.bring(found)
        return found.path

    def bring(self, found: Sealed) -> None:
        """Bring one file back, where it is not here.

        Raises:
            Refused: The store has not its bytes, or does not answer, or the disk refuses.
        """
        if found.path.exists():
            return
        store = self._store()
        try:
            fetch_object(store, store.place.key(found.kind, found.sha256), found.sha256, found.path)
        except OSError as error:
            why = error.strerror or str(error)
            remedy = "make room and try again"
            raise Refused(f"file {found.path.name!r}", f"not writable ({why})", "written", remedy) from error

    @contextmanager
    def reading(self, actor: Account, named: str) -> Generator[SessionReader]:
        """A session or take, from the disk or, where it is not here, in place in the store.

        Args:
            actor: Who asks (verb "view").
            named: Catalogue id.

        Raises:
            Refused: The actor may not, it is unknown, damaged, or the store does not answer.
        """
        require(actor, "view")
        found = sealed_named(self._folder, self._catalogue, named)
        if found.path.exists():
            with SessionReader(found.path) as reader:
                yield reader
            return
        store = self._store()
        with open_object(store, store.place.key(found.kind, found.sha256), found.path) as reader:
            yield reader

    def _worked_off(self, store: ObjectStore) -> Pushed:
        sent = deleted = 0
        refused: list[str] = []
        for errand in self._queue.waiting():
            try:
                if errand.act == "delete":
                    store.delete(store.place.key(errand.kind, errand.sha256))
                    self._marks.forget(errand.kind, errand.sha256)
                    deleted += 1
                    self._queue.remove(errand)
                else:
                    sent += self._sent(store, errand)
            except (Unreachable, Absent):
                raise
            except Refused as refusal:
                refused.append(str(refusal))
        return Pushed(sent, deleted, self.waiting(), tuple(refused))

    def _sent(self, store: ObjectStore, errand: Errand) -> int:
        """Send one file, prove it, and only then strike it off; 1 where it was sent."""
        if not self._queue.holds(errand):
            return 0  # withdrawn meanwhile
        path = self._folder.root / errand.path
        if not path.exists():
            return self._dropped(errand)
        met = storage.digest(path)
        if met != errand.sha256:
            raise Refused(
                f"SHA-256 of {path.name!r}", met, f"{errand.sha256}, as noted", "take the file from a backup"
            )
        key, length = store.place.key(errand.kind, errand.sha256), path.stat().st_size
        store.put(path, key)
        try:
            store.prove(key, errand.sha256, length)
        except (Unreachable, Absent):
            raise
        except Refused:
            store.replace(path, key)  # the file here is proven, so what lies there is not
            store.prove(key, errand.sha256, length)
        self._marks.note(errand.kind, errand.sha256)
        self._queue.remove(errand)
        return 1

    def _dropped(self, errand: Errand) -> int:
        """The file is not here: nothing to do where the catalogue does not know it either."""
        try:
            sealed_named(self._folder, self._catalogue, errand.sha256)
        except Refused:
            self._queue.remove(errand)
            return 0
        name = Path(errand.path).name
        raise Refused(f"file {name!r}", "gone before it was sent", "there", "take it from a backup")

    def _store(self) -> ObjectStore:
        if not self.configured:
            remedy = "set store.bucket in the settings (rehab-app config)"
            raise Refused("object store", "not set", "a bucket", remedy)
        if self._open_store is None:
            said = self._settings
            place = ObjectPlace(
                bucket=said.bucket,
                prefix=said.prefix,
                endpoint=said.endpoint,
                region=said.region,
                access_key=said.access_key,
                secret_key=secret_key(said),
                timeout_s=said.timeout_s,
            )
            self._open_store = ObjectStore(place)
        return self._open_store

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """One process at a time works errands off; the lock dies with it."""
        descriptor = os.open(self._queue.lock_path(), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                remedy = "wait until the server, or the other command, has finished"
                raise Refused(
                    "object store queue", "being worked off by another process", "free", remedy
                ) from None
            yield
        finally:
            os.close(descriptor)

    def _trouble(self) -> Path:
        return self._queue.lock_path().with_name("trouble.txt")

    def _trouble_kept(self) -> str:
        path = self._trouble()
        return path.read_text(encoding="utf-8") if path.exists() else ""

    def _keep_trouble(self, sentence: str) -> None:
        path = self._trouble()
        if not sentence:
            path.unlink(missing_ok=True)
            return
        working = path.with_name(".trouble.new")
        working.write_text(sentence, encoding="utf-8")
        working.replace(path)
