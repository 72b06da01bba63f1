"""Takes: import, record, approve, open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from rehab_app.access import Account, require
from rehab_app.cameras import CameraListing, list_cameras
from rehab_app.cameras.scripted_motion import MOTIONS
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.hand.protocol import PROTOCOLS, load_protocol
from rehab_app.hand.subject import Subject
from rehab_app.recording.take import HandMotion, read_motion
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.calibrations import Calibrations, Hands
from rehab_app.services.patients import side_named
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.services.rows import ImportedSummary, TakeRow
from rehab_app.services.take_shelf import TakeShelf, take_row
from rehab_app.services.take_sources import Listeners, Recorded, import_take, record_take, worth_keeping
from rehab_app.tracking.bare_hand import PROTOCOL as BARE_HAND
from sessions.catalogue import Approval, Catalogue, Take
from sessions.store import SessionReader


@dataclass(frozen=True, slots=True)
class Lineage:
    """Where a take came from that was made of another one.

    Attributes:
        parent: Catalogue id of the other one.
        author: Who made it.
        reason: Why.
        retouch: JSON of what was done.
    """

    parent: str
    author: str
    reason: str
    retouch: str


class Takes:
    """Recorded demonstrations. A ``take`` argument is a path or a catalogue id.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        audit: Where verbs are noted.
        calibrations: Calibrated cameras.
        hands: Known hands.
        stamp: Gives the JSON that says which station this is and how its clock stands.

    Attributes:
        shelf: Takes as lists show them.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        catalogue: Catalogue,
        audit: Audit,
        calibrations: Calibrations,
        hands: Hands,
        stamp: Callable[[], str],
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit
        self._calibrations = calibrations
        self._hands = hands
        self._stamp = stamp
        self.shelf = TakeShelf(folder.root, catalogue)

    def list(self) -> tuple[TakeRow, ...]:
        """All takes, newest first."""
        approved = self._catalogue.approvals()
        return tuple(self._row(take, approved) for take in self._catalogue.takes())

    def get(self, take: str | Path) -> TakeRow:
        """One take; a sealed take file that the clinic does not hold yet is copied into it.

        Raises:
            Refused: There is no such take, its file is gone or is not a take.
        """
        if not storage.is_path(take):
            return self._row(self._catalogue.take(str(take)))
        return self._row(self._entered(Path(take)))

    def exercises(self) -> tuple[str, ...]:
        """Exercises to record: those that the virtual camera shows as well, then the clinic's own."""
        return (*MOTIONS, *(own.name for own in self._catalogue.exercises() if own.name not in MOTIONS))

    def cameras(self) -> tuple[CameraListing, ...]:
        """Cameras that can be recorded from; none is opened."""
        return list_cameras()

    def protocols(self) -> tuple[tuple[str, str], ...]:
        """Name and description of the built-in protocols that a camera can see: markers, and a bare hand."""
        known = [load_protocol(name) for name in PROTOCOLS]
        return tuple(
            (one.name, one.description)
            for one in known
            if one.name == BARE_HAND or any(marker.colour for marker in one.markers)
        )

    def import_file(
        self,
        path: Path,
        *,
        actor: Account,
        side: str = "",
        protocol: str | None = None,
        out: Path | None = None,
    ) -> ImportedSummary:
        """Turn a recording of another program into a take.

        Raises:
            Refused: The actor may not record, or the file cannot become a take.
        """
        require(actor, "record")
        storage.check_out(out)
        target = storage.new_file(self._folder.takes)
        return self._keep(import_take(path, side, protocol, target), "import", actor, out)

    def record(
        self,
        request: RecordingRequest,
        actor: Account,
        out: Path | None = None,
        listeners: Listeners | None = None,
    ) -> ImportedSummary:
        """Record from a camera; the virtual one goes as fast as it can unless in real time.

        The camera's newest calibration is used, and the person's hand where it is known; a hand that was
        learnt well is kept for the next time.

        Args:
            request: What to record.
            actor: Who records.
            out: A copy for the user.
            listeners: Who is told meanwhile.

        Raises:
            Refused: The actor may not record, the camera cannot be used, or the take is shorter than 1 s.
        """
        require(actor, "record")
        storage.check_out(out)
        target = storage.new_file(self._folder.takes)
        known = self._known_hand(request)
        cameras = (request.camera, *request.beside)
        recorded = record_take(
            replace(request, station=self._stamp()),
            target,
            calibrations=tuple(self._calibrations.current(camera) for camera in cameras),
            subject=known,
            listeners=listeners or Listeners(),
        )
        taken = recorded.taken
        if request.person and taken is not None and worth_keeping(taken):
            name = load_protocol(request.protocol).name
            self._hands.keep(actor, request.person, name, taken.subject)
        return self._keep(recorded, "record", actor, out)

    def record_virtual(
        self, exercise: str, side: str, seconds: float, seed: int, actor: Account, out: Path | None = None
    ) -> ImportedSummary:
        """Record from the virtual camera as fast as it goes: see ``record``.

        Raises:
            Refused: The actor may not record, a value is out of bounds, or the take is shorter than 1 s.
        """
        request = RecordingRequest(exercise=exercise, side=side_named(side), seconds=seconds, seed=seed)
        return self.record(request, actor, out)

    def enter(self, path: Path, verb: str, actor: Account, lineage: Lineage | None = None) -> TakeRow:
        """Enter a new take file of the clinic folder into the catalogue.

        Args:
            path: The sealed file.
            verb: What made it, for the audit.
            actor: Who made it.
            lineage: Where it came from; None where it was made of no other take.

        Raises:
            Refused: The actor may not record.
        """
        require(actor, "record")
        row = self._row(self._enter(path, lineage))
        self._audit.note(actor, verb, row.id, row.sha256)
        return row

    def approve(self, take: str | Path, by: Account) -> Approval:
        """Approve exactly this file for play.

        Raises:
            Refused: The account may not approve, there is no such take, or its file was changed.
        """
        require(by, "approve")
        row = self.get(take)
        self.check_unchanged(row)
        approval = self._catalogue.approve(row.id, by.name)
        self._audit.note(by, "approve", row.id, row.sha256)
        return approval

    def approval(self, take: str | Path) -> Approval | None:
        """Who approved the take, None while nobody has.

        Raises:
            Refused: There is no such take.
        """
        return self._catalogue.approval(self.get(take).id)

    def motion(self, take: str | Path) -> HandMotion:
        """The motion in a take.

        Raises:
            Refused: There is no such take, or its file is damaged.
        """
        with SessionReader(self.get(take).path) as reader:
            return read_motion(reader)

    def check_unchanged(self, row: TakeRow) -> None:
        """Refuse a take whose file is not the one that was entered.

        Raises:
            Refused: Its digest differs.
        """
        storage.check_unchanged(f"take {row.id}", row.path, row.sha256)

    def _known_hand(self, request: RecordingRequest) -> Subject | None:
        if not request.person:
            return None
        name = load_protocol(request.protocol).name
        return self._hands.current(request.person, request.side, name)

    def _keep(self, recorded: Recorded, verb: str, actor: Account, out: Path | None) -> ImportedSummary:
        """Enter a new take file into the catalogue and copy it where the user wants one."""
        row = self.enter(recorded.path, verb, actor)
        if row.path != recorded.path:  # the very same file was here already
            recorded.path.unlink()
            storage.digest_beside(recorded.path).unlink(missing_ok=True)
        if out is not None:
            storage.copy_sealed(row.path, out, row.sha256)
        shown = row.path if out is None else out
        return ImportedSummary(
            row.id, shown, row.duration_s, recorded.landmarks, recorded.frames, recorded.gaps, recorded.taken
        )

    def _entered(self, path: Path) -> Take:
        """The catalogue's row of a take file, copied into the clinic folder where it is not there yet."""
        with SessionReader(path) as reader:
            if reader.header.kind != "take":
                raise Refused(
                    f"file {path.name!r}",
                    f"a {reader.header.kind} session",
                    "a take",
                    "name the take it played",
                )
        sha256 = storage.digest(path)
        known = next((take for take in self._catalogue.takes() if take.sha256 == sha256), None)
        if known is not None:
            return known
        target = storage.new_file(self._folder.takes)
        storage.copy_sealed(path, target, sha256)
        return self._enter(target)

    def _enter(self, path: Path, lineage: Lineage | None = None) -> Take:
        with SessionReader(path) as reader:
            header = reader.header
            span = reader.span_ns() or (0, 0)
        take = Take(
            sha256=storage.digest(path),
            path=path.relative_to(self._folder.root).as_posix(),
            side=header.side,
            exercise=header.exercise,
            source=header.source,
            duration_s=(span[1] - span[0]) / 1e9,
            subject_id=header.subject_id,
        )
        return self._catalogue.add_take(take if lineage is None else replace(take, **asdict(lineage)))

    def _row(self, take: Take, approved: dict[str, Approval] | None = None) -> TakeRow:
        approval = self._catalogue.approval(take.id) if approved is None else approved.get(take.id)
        return take_row(self._folder.root, take, approval)
