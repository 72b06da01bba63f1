"""The standing prescription of a patient: read, change, and the take that an item plays."""

from __future__ import annotations

import threading
from dataclasses import replace

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.clinical import Clinical
from rehab_app.services.exercises import Exercises
from rehab_app.services.plan_items import Plan, PlanItem
from rehab_app.services.plan_strength import stronger
from rehab_app.services.rows import TakeRow
from rehab_app.services.takes import Takes
from sessions.catalogue import Catalogue, PatientEntry

_KIND = "plan"


class Plans:
    """Plans of patients; a version is never changed, the newest counts.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where changes are noted.
        takes: Where takes are found.
        exercises: The library.
        clinical: What a patient's diagnosis locks.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, takes: Takes, exercises: Exercises, clinical: Clinical
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._takes = takes
        self._exercises = exercises
        self._clinical = clinical
        self._changing = threading.Lock()

    def current(self, patient_id: str) -> Plan:
        """The plan that holds; one without items and with version 0 where nobody prescribed anything.

        Raises:
            Refused: There is no such patient.
        """
        rows = self._catalogue.entries(patient_id, (_KIND,), limit=1)
        return _plan(rows[0]) if rows else Plan(patient=self._catalogue.patient(patient_id).id)

    def history(self, patient_id: str, limit: int = 50) -> tuple[Plan, ...]:
        """Every version, newest first.

        Raises:
            Refused: There is no such patient.
        """
        return tuple(_plan(row) for row in self._catalogue.entries(patient_id, (_KIND,), limit=limit))

    def change(self, actor: Account, plan: Plan) -> Plan:
        """Make a new version of a plan. Safer is anyone's who treats, anything else a therapist's.

        Args:
            actor: Who changes (verb "note"; "prescribe" for what is stronger or another treatment).
            plan: The plan as it shall be; ``version`` is the one it was made from. New items have key 0.

        Returns:
            The new version, every item with its key.

        Raises:
            Refused: The actor may not, somebody else changed the plan meanwhile, nothing differs, or an
                exercise or take is unknown.
        """
        require(actor, "note")
        for item in plan.items:
            self._check(item)
        with self._changing:
            before = self.current(plan.patient)
            _check_version(before, plan)
            more = stronger(before, plan)
            if more:
                _require_therapist(actor, more)
            made = _numbered(replace(plan, by=actor.name), self.history(plan.patient))
            if before.version and _content(made) == _content(before):
                raise Refused("plan", "as it was", "changed", "change something, or leave the page")
            row = self._catalogue.add_version(
                PatientEntry(
                    patient=plan.patient,
                    kind=_KIND,
                    content=msgspec.json.encode(made).decode(),
                    by=actor.name,
                ),
                since=before.version,  # another station may write between reading and here
            )
        self._audit.note(actor, "change plan", plan.patient, f"version {row.id}, {len(plan.items)} items")
        return _plan(row)

    def playable(self, plan: Plan, item: PlanItem) -> TakeRow | None:
        """The approved take that an item plays; None where there is none yet.

        It is the named take, else the newest approved one of the exercise, of the patient's own side first.
        """
        return self.playables(replace(plan, items=(item,)))[0]

    def playables(self, plan: Plan) -> tuple[TakeRow | None, ...]:
        """For each item of a plan the approved take that it plays, see ``playable``."""
        side = self._catalogue.patient(plan.patient).side
        newest = {
            name: self._takes.shelf.newest(name, side)
            for name in dict.fromkeys(item.exercise for item in plan.items if not item.take)
        }
        return tuple(self._approved(item.take) if item.take else newest[item.exercise] for item in plan.items)

    def notes(self, plan: Plan, playables: tuple[TakeRow | None, ...] | None = None) -> tuple[str, ...]:
        """What keeps a plan from being played today, one sentence each: locked modes, missing takes.

        Args:
            plan: The plan.
            playables: What ``playables`` gave for it, None to ask again.
        """
        takes = self.playables(plan) if playables is None else playables
        locks = self._clinical.locks(plan.patient)
        said = [locks[mode] for mode in dict.fromkeys(item.mode for item in plan.items) if mode in locks]
        for number, (item, take) in enumerate(zip(plan.items, takes, strict=True), start=1):
            if take is None:
                words = self._exercises.get(item.exercise).words
                said.append(f"Item {number}, {words}: no approved take yet.")
        return tuple(said)

    def _approved(self, take: str) -> TakeRow | None:
        """The take that an item names, None where it is gone or not approved."""
        row = self._takes.shelf.named(take)
        return row if row is not None and row.approved_by is not None else None

    def _check(self, item: PlanItem) -> None:
        """Refuse an item whose exercise or take the clinic does not have.

        Raises:
            Refused: It is one of these, or the take is of another exercise.
        """
        known = self._exercises.get(item.exercise)
        if item.take:
            row = self._takes.get(item.take)
            if row.exercise != known.name:
                value = f"of {row.exercise}"
                raise Refused(f"take {row.id}", value, f"of {known.name}", "choose a take of the exercise")


def _plan(row: PatientEntry) -> Plan:
    """The plan in a row of the catalogue."""
    read = msgspec.json.decode(row.content, type=Plan)
    return replace(read, patient=row.patient, version=row.id, by=row.by, created_utc_ns=row.created_utc_ns)


def _content(plan: Plan) -> Plan:
    """The plan without what only says which version it is."""
    return replace(plan, version=0, by="", created_utc_ns=0, reason="")


def _numbered(plan: Plan, versions: tuple[Plan, ...]) -> Plan:
    """The plan with a key for each new item that no version has used."""
    used = [item.key for version in versions for item in version.items]
    free = max((*used, *(item.key for item in plan.items), 0)) + 1
    items: list[PlanItem] = []
    for item in plan.items:
        items.append(item if item.key else replace(item, key=free))
        free += 0 if item.key else 1
    return replace(plan, items=tuple(items))


def _check_version(before: Plan, asked: Plan) -> None:
    if asked.version != before.version:
        who = f"changed by {before.by} meanwhile" if before.version else "no longer there"
        raise Refused(
            f"plan of {before.patient}",
            f"{who} (version {before.version}, yours was {asked.version})",
            "unchanged since you opened it",
            "compare and save again",
        )


def _require_therapist(actor: Account, more: tuple[str, ...]) -> None:
    if actor.may("prescribe"):
        return
    value = "stronger or another treatment (" + "; ".join(more[:4]) + ")"
    raise Refused(
        f"plan changed by {actor.name}, {actor.role}", value, "safer only", "ask a therapist to prescribe it"
    )
