"""Sealed files of a clinic in its object store: sent, proven, erased, taken off the disk and brought back."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder, StoreSettings
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.object_courier import Courier, Pushed
from rehab_app.services.object_opening import open_store
from rehab_app.services.object_queue import ErrandQueue, StoredMarks
from rehab_app.services.object_rooms import Sealed, sealed_files, sealed_named
from sessions.catalogue import Catalogue
from sessions.filelock import alone
from sessions.store import SessionReader
from sessions.store.object_source import fetch_object, open_object
from sessions.store.object_store import ObjectStore

_DAY_S = 86_400.0


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
        self._courier = Courier(folder, catalogue, self._queue, self._marks)
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
        return StoreStatus(self._settings.bucket, to_send, deletions, len(self._marks), self._queue.trouble())

    def gather(self) -> int:
        """Queue every sealed file of the catalogue that the store has not; how many were added.

        Nothing is lost when a process ends between sealing and queuing: the next call finds the file.

        Raises:
            Refused: The disk refuses.
        """
        if not self.configured:
            return 0
        added = 0
        for found in sealed_files(self._folder, self._catalogue, self._seen, self._marks.has):
            put, delete = found.errand("put"), found.errand("delete")
            if not self._queue.holds(put) and not self._queue.holds(delete):
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
            Refused: The actor may not, there is no store, another process is at it, or the disk refuses.
        """
        require(actor, "backup")
        store = self._store()
        with self._alone():
            self.gather()
            try:
                done = self._courier.work_off(store)
            except Refused as refusal:
                with suppress(Refused):  # a full disk keeps no reason, and must not hide this one
                    self._queue.keep_trouble(str(refusal))
                raise
            self._queue.keep_trouble(" ".join(done.refused))
        return done

    def evict(self, actor: Account, older_than_days: float) -> tuple[str, ...]:
        """Take sessions off the disk whose objects are proven now, once more; their digests stay.

        Takes stay: therapy plays them, also without a network.

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
        try:
            with self._alone():
                for found in sealed_files(self._folder, self._catalogue):
                    if found.kind == "sessions" and self._evicted(store, found, before_s):
                        gone.append(found.relative(self._folder.root))
        finally:
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

    def _evicted(self, store: ObjectStore, found: Sealed, before_s: float) -> bool:
        state = found.path.stat()
        if state.st_mtime > before_s or not self._marks.has(found.kind, found.sha256):
            return False
        store.prove(store.place.key(found.kind, found.sha256), found.sha256, state.st_size)
        found.path.unlink()
        self._seen.discard(found.path)
        return True

    def _store(self) -> ObjectStore:
        if not self.configured:
            remedy = "set store.bucket in the settings (rehab-app config)"
            raise Refused("object store", "not set", "a bucket", remedy)
        if self._open_store is None:
            self._open_store = open_store(self._settings)
        return self._open_store

    @contextmanager
    def _alone(self) -> Generator[None]:
        """One process at a time works errands off; the lock dies with it."""
        with alone(self._queue.lock_path()) as free:
            if not free:
                remedy = "wait until the server, or the other command, has finished"
                raise Refused("object store queue", "being worked off by another process", "free", remedy)
            yield
