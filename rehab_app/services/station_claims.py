"""A patient is in therapy at one station only: claims in the catalogue, renewed off the control path."""

from __future__ import annotations

import secrets
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass

from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.station_marks import StationMarks
from sessions.catalogue import Catalogue
from sessions.errors import NoAnswer

LASTS_S = 60.0
RENEW_S = 20.0
SAME_SESSION_S = 900.0
"""So long after a run of a patient here, the next one may begin without the catalogue."""
_LAST_WAIT_S = 2.0
_LONGEST_NAME = 63


@dataclass(frozen=True, slots=True)
class StationIdentity:
    """Who a process is among the clinic's stations.

    Attributes:
        name: Name of the station.
        holder: Drawn by chance for this process, so that two of one name are told apart.
        version: Version of its software.
    """

    name: str
    holder: str
    version: str


def identity_of(name: str, version: str) -> StationIdentity:
    """The identity of this process.

    Args:
        name: Name of the station; its first 63 characters count.
        version: Version of its software.
    """
    return StationIdentity(name[:_LONGEST_NAME] or "station", secrets.token_hex(8), version)


class Claims:
    """Claims of one process. A run that goes on is never stopped or delayed by them.

    Starting asks the catalogue before anything moves. From then on a thread of its own renews, and releases
    when the run has ended: whatever it meets is kept as a sentence and told, and the run goes on. Where the
    catalogue does not answer, a patient who was treated here just before may go on with the next exercise of
    the session; anybody else waits, for nobody knows whether they are in therapy elsewhere.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where a claim that was taken over is noted.
        identity: Who claims.
        marks: Tells which processes of this folder died: what they held is free at once.
        lasts_s: How long a claim binds without being renewed.
        renew_s: How often it is renewed.
        clock_s: A clock that never goes back, in s.

    Attributes:
        trouble: Why the last renewal did not succeed, "" where it did.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        audit: Audit,
        identity: StationIdentity,
        marks: StationMarks,
        lasts_s: float = LASTS_S,
        renew_s: float = RENEW_S,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self.identity = identity
        self._marks = marks
        self._lasts_ns = round(lasts_s * 1e9)
        self._renew_s = renew_s
        self._clock_s = clock_s
        self._asking = threading.Lock()  # claiming and releasing; never taken by a run that goes on
        self._counting = threading.Lock()  # held for a count only
        self._held: Counter[str] = Counter()
        self._leaving: set[str] = set()
        self._treated_s: dict[str, float] = {}
        self._woken = threading.Event()
        self._ended = False
        self._thread: threading.Thread | None = None
        self.trouble = ""

    def start(self, patient_id: str) -> None:
        """Claim a patient before therapy or an assessment begins; again within it costs nothing.

        Args:
            patient_id: Pseudonym; empty for a demonstration, which claims nobody.

        Raises:
            Refused: The patient is unknown or in therapy at another station, or nothing answers or can be
                written.
        """
        if not patient_id or self._again(patient_id):
            return
        self._marks.take()
        with self._asking:
            try:
                self._claim(patient_id)
            except NoAnswer as away:
                if not self._was_here(patient_id):
                    raise
                self.trouble = f"{patient_id} goes on here without a claim: {away}"
            with self._counting:
                self._held[patient_id] += 1
                self._leaving.discard(patient_id)
        self._keep_up()

    def end(self, patient_id: str) -> None:
        """Set a patient free; returns at once, the catalogue is told on another thread."""
        with self._counting:
            if self._held[patient_id] > 1:
                self._held[patient_id] -= 1
                return
            if self._held.pop(patient_id, 0):
                self._leaving.add(patient_id)
                self._treated_s[patient_id] = self._clock_s()
        self._woken.set()

    @contextmanager
    def held(self, patient_id: str) -> Generator[None]:
        """A claim for as long as the block runs.

        Raises:
            Refused: As of ``start``.
        """
        self.start(patient_id)
        try:
            yield
        finally:
            self.end(patient_id)

    def renew(self) -> None:
        """Renew what is held, now; trouble is kept as a sentence and tried again later."""
        with self._counting:
            held = list(self._held)
        said = ""
        for patient in held:
            try:
                self._claim(patient)
            except Refused as refusal:
                said = f"The claim of {patient} was not renewed, therapy here goes on: {refusal}"
        self.trouble = said

    def close(self) -> None:
        """Set everybody free who was held, and end."""
        with self._counting:
            self._leaving.update(self._held)
            self._held.clear()
            self._ended = True
        self._woken.set()
        if self._thread is not None:
            self._thread.join(_LAST_WAIT_S)
        self._marks.release()

    def _was_here(self, patient_id: str) -> bool:
        """Whether a run of the patient ended here just before."""
        with self._counting:
            ended_s = self._treated_s.get(patient_id)
        return ended_s is not None and self._clock_s() - ended_s <= SAME_SESSION_S

    def _again(self, patient_id: str) -> bool:
        with self._counting:
            if not self._held[patient_id]:
                return False
            self._held[patient_id] += 1
            return True

    def _claim(self, patient_id: str) -> None:
        me, gone = self.identity, self._marks.gone()
        _, before = self._catalogue.claim_patient(patient_id, me.name, me.holder, self._lasts_ns, gone)
        if before is not None:
            how = "died with its process" if before.holder in gone else "had run out"
            detail = f"at {me.name}, the claim of {before.station} {how}"
            self._audit.note_later(me.name, "take over patient", patient_id, detail)

    def _keep_up(self) -> None:
        """The thread begins with the first claim."""
        with self._counting:
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="claims", daemon=True)
                self._thread.start()

    def _work(self) -> None:
        due_s = time.monotonic() + self._renew_s
        while not self._ended:
            self._woken.wait(max(0.0, due_s - time.monotonic()))
            self._woken.clear()
            self._release()
            if time.monotonic() >= due_s:
                self.renew()
                due_s = time.monotonic() + self._renew_s
        self._release()

    def _release(self) -> None:
        """Release whoever left; where the catalogue does not answer, the claim runs out by itself."""
        while True:
            with self._asking:
                with self._counting:
                    if not self._leaving:
                        return
                    patient = self._leaving.pop()
                try:
                    self._catalogue.release_patient(patient, self.identity.holder)
                except Refused as refusal:
                    self.trouble = f"{patient} could not be set free and will be within a minute: {refusal}"
