"""How long patients are kept: a setting, a list of who is due; a person erases, nothing else does."""

from __future__ import annotations

import time
from collections.abc import Callable

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from sessions.catalogue import Catalogue, Setting

KEY = "retention"
USUAL_YEARS = 10
_LONGEST = 100
_YEAR_NS = int(365.25 * 86400) * 1_000_000_000


class Retention:
    """The retention rule of a clinic.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where changes are noted.
        clock_ns: UTC in ns.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, clock_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._clock_ns = clock_ns

    def years(self) -> int:
        """Years after the last entry or session; 0 keeps everything."""
        kept = self._catalogue.setting(KEY)
        return USUAL_YEARS if kept is None else msgspec.json.decode(kept.content, type=int)

    def set_years(self, actor: Account, years: int) -> None:
        """Change it.

        Raises:
            Refused: The actor may not erase, or it is none of 0 to 100.
        """
        require(actor, "erase")
        if not 0 <= years <= _LONGEST:
            bound = f"0 (keep) to {_LONGEST} years"
            raise Refused("retention", f"{years} years", bound, "choose what the law of the place asks")
        self._catalogue.set(Setting(key=KEY, content=str(years), by=actor.name))
        self._audit.note(actor, "set retention", "", f"{years} years")

    def due(self) -> tuple[str, ...]:
        """Pseudonyms of patients of whom nothing was recorded or written for that long, longest ago first."""
        years = self.years()
        if years == 0:
            return ()
        before = self._clock_ns() - years * _YEAR_NS
        late = [(at, patient) for patient, at in self._catalogue.last_activity().items() if at < before]
        return tuple(patient for _, patient in sorted(late))
