"""Takes: import, record, approve, open."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rehab_app.access import Account, require
from rehab_app.cameras.scripted_motion import MOTIONS
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.recording.pipeline import LivePose
from rehab_app.recording.take import HandMotion, read_motion
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.patients import side_named
from rehab_app.services.rows import ImportedSummary, TakeRow
from rehab_app.services.take_sources import Recorded, import_take, record_take
from sessions.catalogue import Approval, Catalogue, Take
from sessions.records import Side
from sessions.store import SessionReader

SHORTEST_S = 1.0
LONGEST_S = 600.0


class Takes:
    """Recorded demonstrations. A ``take`` argument is a path or a catalogue id.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        audit: Where verbs are noted.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue, audit: Audit) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit

    def list(self) -> tuple[TakeRow, ...]:
        """All takes, newest first."""
        return tuple(self._row(take) for take in self._catalogue.takes())

    def get(self, take: str | Path) -> TakeRow:
        """One take; a sealed take file that the clinic does not hold yet is copied into it.

        Raises:
            Refused: There is no such take, its file is gone or is not a take.
        """
        if not storage.is_path(take):
            return self._row(self._catalogue.take(str(take)))
        return self._row(self._entered(Path(take)))

    def exercises(self) -> tuple[str, ...]:
        """Exercises that the virtual camera knows."""
        return MOTIONS

    def import_file(
        self,
        path: Path,
        *,
        actor: Account,
        side: str = "right",
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

    def record_virtual(
        self,
        exercise: str,
        side: str,
        seconds: float,
        seed: int,
        actor: Account,
        out: Path | None = None,
        *,
        realtime: bool = False,
        on_frame: Callable[[LivePose], None] | None = None,
        finished: Callable[[], bool] | None = None,
    ) -> ImportedSummary:
        """Record from the virtual camera, as fast as it goes unless in real time.

        Args:
            exercise: One of ``exercises()``.
            side: Side of the hand.
            seconds: Length, 1 to 600 s.
            seed: Seed of the camera's noise and the hand's sway.
            actor: Who records.
            out: A copy for the user.
            realtime: Frames come at their time of capture.
            on_frame: Told of every frame.
            finished: Asked at every frame whether to end early.

        Raises:
            Refused: The actor may not record, a value is out of bounds, or the take is shorter than 1 s.
        """
        require(actor, "record")
        sided = self.check_recording(exercise, side, seconds)
        storage.check_out(out)
        target = storage.new_file(self._folder.takes)
        recorded = record_take(
            exercise,
            sided,
            seconds,
            seed,
            target,
            realtime=realtime,
            on_frame=on_frame,
            finished=finished,
        )
        return self._keep(recorded, "record", actor, out)

    def check_recording(self, exercise: str, side: str, seconds: float) -> Side:
        """Refuse what cannot be recorded, before anything starts; the side as one that exists.

        Raises:
            Refused: A value is out of bounds.
        """
        if exercise not in MOTIONS:
            raise Refused("exercise", repr(exercise), "one of " + ", ".join(MOTIONS), "choose one of them")
        if not SHORTEST_S <= seconds <= LONGEST_S:
            raise Refused(
                "take", f"{seconds:g} s long", f"{SHORTEST_S:g} to {LONGEST_S:g} s", "choose another length"
            )
        return side_named(side)

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
        met = storage.digest(row.path)
        if met != row.sha256:
            raise Refused(
                f"take {row.id}", f"changed (SHA-256 {met[:12]})", row.sha256[:12], "restore it from a backup"
            )

    def _keep(self, recorded: Recorded, verb: str, actor: Account, out: Path | None) -> ImportedSummary:
        """Enter a new take file into the catalogue and copy it where the user wants one."""
        row = self._row(self._enter(recorded.path))
        self._audit.note(actor, verb, row.id, row.sha256)
        if row.path != recorded.path:  # the very same file was here already
            recorded.path.unlink()
            storage.digest_beside(recorded.path).unlink(missing_ok=True)
        if out is not None:
            storage.copy_sealed(row.path, out, row.sha256)
        shown = row.path if out is None else out
        return ImportedSummary(
            row.id, shown, row.duration_s, recorded.landmarks, recorded.frames, recorded.gaps
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

    def _enter(self, path: Path) -> Take:
        with SessionReader(path) as reader:
            header = reader.header
            span = reader.span_ns() or (0, 0)
        return self._catalogue.add_take(
            Take(
                sha256=storage.digest(path),
                path=path.relative_to(self._folder.root).as_posix(),
                side=header.side,
                exercise=header.exercise,
                source=header.source,
                duration_s=(span[1] - span[0]) / 1e9,
                subject_id=header.subject_id,
            )
        )

    def _row(self, take: Take) -> TakeRow:
        approval = self._catalogue.approval(take.id)
        return TakeRow(
            id=take.id,
            path=self._folder.root / take.path,
            sha256=take.sha256,
            side=take.side,
            exercise=take.exercise,
            source=take.source,
            duration_s=take.duration_s,
            created_utc_ns=take.created_utc_ns,
            approved_by=None if approval is None else approval.by,
        )
