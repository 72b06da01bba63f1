"""What the catalogue said last: enough to finish and to record while its server does not answer."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Generator, Hashable, Iterable
from contextlib import contextmanager, suppress
from typing import Any, ParamSpec, TypeVar, cast

from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.outbox_reach import Reach
from sessions.catalogue import (
    Approval,
    AssistanceMemory,
    CameraCalibration,
    Catalogue,
    ClinicalRecord,
    DayLimits,
    Exercise,
    FitCheck,
    Hand,
    LimitChange,
    ModeUnlock,
    Patient,
    Setting,
    Take,
    TakeFilter,
    TherapySession,
)
from sessions.catalogue.beginnings import Begun
from sessions.catalogue.erasure import Belongings
from sessions.records import Side

V = TypeVar("V")
P = ParamSpec("P")
_MOST = 2048


class RememberingCatalogue(Catalogue):
    """A catalogue whose answers to what a run or a recording asks hold until it answers again.

    Nothing new is decided by them: whoever begins therapy claims the patient first, whoever signs in is
    looked up first, and neither is remembered.

    Args:
        given: As of a catalogue: an engine, and a clock.

    Attributes:
        reach: Whether the server answers.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.reach = Reach()
        self._remembering = threading.Lock()
        self._last: OrderedDict[Hashable, object] = OrderedDict()
        self._stand_ins: dict[str, Take | TherapySession] = {}
        self._here: tuple[object, ...] = ()

    def patient(self, pseudonym: str) -> Patient:
        """As the catalogue says, or said last."""
        return self._known(super().patient, pseudonym)

    def patients(self, *, archived: bool = False) -> tuple[Patient, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().patients, archived=archived)

    def take(self, take: str) -> Take:
        """As the catalogue says, or said last; also one that waits."""
        try:
            return self._known(super().take, take)
        except Refused:
            held = self._stand_ins.get(take)
            if isinstance(held, Take):
                return held
            raise

    def takes(self) -> tuple[Take, ...]:
        """As the catalogue says, or said last; also those that wait."""
        found = self._known(super().takes)
        known = {take.sha256 for take in found}
        held = {one.sha256: one for one in self._stand_ins.values() if isinstance(one, Take)}
        return (*(held[sha256] for sha256 in reversed(held) if sha256 not in known), *found)

    def approval(self, take: str) -> Approval | None:
        """As the catalogue says, or said last; none of a take that waits."""
        try:
            return self._known(super().approval, take)
        except Refused:
            if take in self._stand_ins:
                return None
            raise

    def approvals(self, takes: tuple[str, ...] | None = None) -> dict[str, Approval]:
        """As the catalogue says, or said last."""
        return self._known(super().approvals, takes)

    def recent_patients(self, count: int) -> tuple[tuple[Patient, ...], int]:
        """As the catalogue says, or said last."""
        return self._known(super().recent_patients, count)

    def lately_treated(self) -> tuple[str, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().lately_treated)

    def find_takes(self, wanted: TakeFilter, start: int, count: int) -> tuple[tuple[Take, ...], int]:
        """As the catalogue says, or said last; those that wait come first, on the first page."""
        found, total = self._known(super().find_takes, wanted, start, count)
        held = {one.sha256: one for one in self._stand_ins.values() if isinstance(one, Take)}
        known = {take.sha256 for take in found}
        waiting = tuple(
            held[sha256] for sha256 in reversed(held) if sha256 not in known and wanted.fits(held[sha256])
        )
        return (*(waiting if start == 0 else ()), *found), total + len(waiting)

    def take_counts(self, *, approved: bool = False) -> dict[str, int]:
        """As the catalogue says, or said last."""
        return self._known(super().take_counts, approved=approved)

    def patients_named(self, pseudonyms: tuple[str, ...]) -> tuple[Patient, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().patients_named, pseudonyms)

    def demonstrators(self, count: int) -> tuple[Patient, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().demonstrators, count)

    def exercises(self) -> tuple[Exercise, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().exercises)

    def session(self, therapy: str) -> TherapySession:
        """As the catalogue says, or said last; also one that waits."""
        try:
            return self._known(super().session, therapy)
        except Refused:
            held = self._stand_ins.get(therapy)
            if isinstance(held, TherapySession):
                return held
            raise

    def sessions(self, patient: str = "") -> tuple[TherapySession, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().sessions, patient)

    def begun(self) -> Begun:
        """As the catalogue says, or said last."""
        return self._known(super().begun)

    def clinical_records(self, patient: str) -> tuple[ClinicalRecord, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().clinical_records, patient)

    def mode_unlocks(self, patient: str) -> tuple[ModeUnlock, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().mode_unlocks, patient)

    def day_limits(self, patient: str, device: str) -> tuple[DayLimits, ...]:
        """As the catalogue says, or said last; before them those that wait."""
        waiting = self._waiting(DayLimits, lambda one: (one.patient, one.device) == (patient, device))
        return (*waiting, *self._known(super().day_limits, patient, device))

    def limit_changes(self, patient: str, device: str) -> tuple[LimitChange, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().limit_changes, patient, device)

    def fit_checks(self, patient: str, device: str) -> tuple[FitCheck, ...]:
        """As the catalogue says, or said last; before them those that wait."""
        waiting = self._waiting(FitCheck, lambda one: (one.patient, one.device) == (patient, device))
        return (*waiting, *self._known(super().fit_checks, patient, device))

    def assistance(self, patient: str, exercise: str, device: str) -> AssistanceMemory | None:
        """As the catalogue says, or said last; what waits is newer."""
        wanted = (patient, exercise, device)
        waiting = self._waiting(
            AssistanceMemory, lambda one: (one.patient, one.exercise, one.device) == wanted
        )
        return waiting[0] if waiting else self._known(super().assistance, patient, exercise, device)

    def calibrations(self, camera: str = "") -> tuple[CameraCalibration, ...]:
        """As the catalogue says, or said last."""
        return self._known(super().calibrations, camera)

    def hands(self, person: str, side: Side | None = None, protocol: str = "") -> tuple[Hand, ...]:
        """As the catalogue says, or said last; before them those that wait."""
        waiting = self._waiting(
            Hand,
            lambda one: one.person == person and side in (None, one.side) and protocol in ("", one.protocol),
        )
        return (*waiting, *self._known(super().hands, person, side, protocol))

    def kept_metrics(self, sha256s: Iterable[str], version: str) -> dict[str, str]:
        """Kept numbers; where nobody answers none, and they are computed again."""
        try:
            return super().kept_metrics(sha256s, version)
        except NoAnswer:
            return {}

    def keep_metrics(self, sha256: str, version: str, content: str) -> None:
        """Keep the numbers of a file; where that cannot be now, they are computed again."""
        with suppress(NoAnswer):
            super().keep_metrics(sha256, version, content)

    def setting(self, key: str) -> Setting | None:
        """As the catalogue says, or said last."""
        return self._known(super().setting, key)

    def see_sign_in(self, digest: str) -> None:
        """Note the use of a sign-in; where that cannot be noted now, the next use is."""
        with suppress(NoAnswer):
            super().see_sign_in(digest)

    def erase_patient(self, patient: str, remember: str, by: str) -> Belongings:
        """Erase every row about a patient, and what is remembered here."""
        self.forget()
        return super().erase_patient(patient, remember, by)

    def forget(self) -> None:
        """Remember nothing more, and have nothing stand in for what waits."""
        with self._remembering:
            self._last.clear()
        self.forget_stand_ins()

    def forget_stand_ins(self) -> None:
        """Whatever waited has arrived or was set aside: the catalogue's own rows count."""
        self._stand_ins, self._here = {}, ()

    def _waiting(self, kind: type[V], fits: Callable[[V], bool]) -> tuple[V, ...]:
        """Rows that wait, newest first: what was measured here a moment ago holds at once."""
        return tuple(one for one in reversed(self._here) if isinstance(one, kind) and fits(one))

    def _known(self, ask: Callable[P, V], *given: P.args, **named: P.kwargs) -> V:
        key = (ask.__name__, given, tuple(named.items()))
        try:
            found = ask(*given, **named)
        except NoAnswer:
            with self._remembering:
                if key not in self._last:
                    raise
                return cast("V", self._last[key])
        with self._remembering:
            self._last[key] = found
            self._last.move_to_end(key)
            if len(self._last) > _MOST:
                self._last.popitem(last=False)
        return found

    @contextmanager
    def _answering(self) -> Generator[None]:
        self.reach.check()
        try:
            with super()._answering():
                yield
        except NoAnswer as said:
            self.reach.lost(said)
            raise
        else:
            self.reach.answered()
