"""Values of outcome measures over time: first, last, newest, and what the change means."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

from rehab_app.services.outcome_measures import MEASURES, Measure

Meaning: TypeAlias = Literal["matters", "may matter", "too small to matter", "not known", ""]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One value of an outcome measure.

    Attributes:
        id: Number of the entry.
        patient: Pseudonym.
        measure: Key of the measure.
        value: In the measure's unit (angles in rad).
        side: Hand that was tested, empty where the measure has none.
        place: Joint, digit or kind of grip, empty where the measure has none.
        measured_on: ISO date.
        remark: Anything else.
        by: Who entered it.
        created_utc_ns: When it was entered.
        corrects: Number of the entry that it takes the place of, 0 for none.
        corrected_by: Number of the entry that took its place, 0 while it holds.
    """

    id: int
    patient: str
    measure: str
    value: float
    side: str
    place: str
    measured_on: str
    remark: str
    by: str
    created_utc_ns: int
    corrects: int = 0
    corrected_by: int = 0


@dataclass(frozen=True, slots=True)
class Series:
    """One measure of one hand and place over time.

    Attributes:
        measure: The measure.
        side: Hand, empty where the measure has none.
        place: Joint, digit or kind of grip, empty where the measure has none.
        rows: Values, oldest first; at least one.
    """

    measure: Measure
    side: str
    place: str
    rows: tuple[Outcome, ...]

    @property
    def baseline(self) -> Outcome:
        """The first value."""
        return self.rows[0]

    @property
    def now(self) -> Outcome:
        """The newest value."""
        return self.rows[-1]

    @property
    def last(self) -> Outcome | None:
        """The value before the newest, None where there is only one."""
        return self.rows[-2] if len(self.rows) > 1 else None

    @property
    def change(self) -> float | None:
        """Newest less first, in the measure's unit; None where there is only one."""
        return None if self.last is None else self.now.value - self.baseline.value

    @property
    def since_last(self) -> float | None:
        """Newest less the one before, in the measure's unit; None where there is only one."""
        return None if self.last is None else self.now.value - self.last.value

    @property
    def direction(self) -> str:
        """better, worse, same, or empty where there is only one."""
        change = self.change
        if change is None:
            return ""
        if abs(change) < 1e-9:
            return "same"
        return "better" if (change > 0) == (self.measure.better == "higher") else "worse"

    @property
    def meaning(self) -> Meaning:
        """The change since the first value beside what is published to matter to patients."""
        change, bound = self.change, self.measure.mcid
        if change is None:
            return ""
        if bound is None:
            return "not known"
        if abs(change) >= bound[1] - 1e-9:
            return "matters"
        return "may matter" if abs(change) >= bound[0] - 1e-9 else "too small to matter"


def series_of(rows: Iterable[Outcome]) -> tuple[Series, ...]:
    """Values, oldest first, by measure, hand and place, in the order of the measures."""
    groups: dict[tuple[int, str, int], list[Outcome]] = {}
    keys = [one.key for one in MEASURES]
    for row in rows:
        column = keys.index(row.measure)
        places = MEASURES[column].places
        place = places.index(row.place) if row.place in places else -1
        groups.setdefault((column, row.side, place), []).append(row)
    return tuple(
        Series(MEASURES[group[0]], group[1], held[0].place, tuple(held))
        for group, held in sorted(groups.items())
    )
