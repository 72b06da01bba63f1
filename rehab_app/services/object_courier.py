"""Works waiting errands off: an errand is struck off only after the store has proven what was done."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.object_queue import Errand, ErrandQueue, StoredMarks
from rehab_app.services.object_rooms import sealed_named
from sessions.catalogue import Catalogue
from sessions.store.object_store import ObjectStore
from sessions.store.object_trouble import Unreachable


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


class Courier:
    """Sends and deletes.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        queue: What waits.
        marks: Where proven files are noted.
    """

    def __init__(
        self, folder: ClinicFolder, catalogue: Catalogue, queue: ErrandQueue, marks: StoredMarks
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._queue = queue
        self._marks = marks

    def work_off(self, store: ObjectStore) -> Pushed:
        """Every errand once; one that is refused for itself does not hold up the others.

        Raises:
            Unreachable: The store does not answer or does not allow it; everything left is kept.
        """
        sent = deleted = 0
        refused: list[str] = []
        for errand in self._queue.waiting():
            try:
                if errand.act == "delete":
                    deleted += self._deleted(store, errand)
                else:
                    sent += self._sent(store, errand)
            except Unreachable:
                raise
            except Refused as refusal:
                refused.append(str(refusal))
        return Pushed(sent, deleted, len(self._queue.waiting()), tuple(refused))

    def _deleted(self, store: ObjectStore, errand: Errand) -> int:
        store.delete(store.place.key(errand.kind, errand.sha256))
        self._marks.forget(errand.kind, errand.sha256)
        self._queue.remove(errand)
        return 1

    def _sent(self, store: ObjectStore, errand: Errand) -> int:
        """Send one file, prove it, and only then strike it off; 1 where it was sent."""
        if not self._queue.holds(errand):
            return 0  # withdrawn meanwhile
        path = self._folder.root / errand.path
        if not path.is_file():
            return self._dropped(errand)
        met = storage.digest(path)
        if met != errand.sha256:
            noted = f"{errand.sha256}, as noted beside it"
            raise Refused(f"SHA-256 of {path.name!r}", met, noted, "take the file from a backup")
        self._put(store, path, errand)
        self._marks.note(errand.kind, errand.sha256)
        self._queue.remove(errand)
        return 1

    def _put(self, store: ObjectStore, path: Path, errand: Errand) -> None:
        key, length = store.place.key(errand.kind, errand.sha256), path.stat().st_size
        store.put(path, key)
        try:
            store.prove(key, errand.sha256, length)
        except Unreachable:
            raise
        except Refused:
            store.replace(path, key)  # the file here is proven, so what lies there is not
            store.prove(key, errand.sha256, length)

    def _dropped(self, errand: Errand) -> int:
        """The file is not here: nothing to do where the catalogue does not know it either."""
        try:
            sealed_named(self._folder, self._catalogue, errand.sha256)
        except Refused:
            self._queue.remove(errand)
            return 0
        name = Path(errand.path).name
        raise Refused(f"file {name!r}", "gone before it was sent", "there", "take it from a backup")
