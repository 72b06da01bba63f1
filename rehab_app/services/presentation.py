"""How a clinic presents itself: the name on its reports, the language for who has not chosen one."""

from __future__ import annotations

import time
from collections.abc import Callable

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.plain_text import one_line
from sessions.catalogue import Catalogue, Setting

NAME_KEY = "clinic-name"
LANGUAGE_KEY = "clinic-language"
LONGEST_NAME = 120
_FRESH_NS = 10_000_000_000


class Presentation:
    """Name and language of a clinic.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where changes are noted.
        clock_ns: Monotonic clock in ns.

    Attributes:
        usual_language: What ``language`` gave last: for whoever may not wait for a data base.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, clock_ns: Callable[[], int] = time.monotonic_ns
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._clock_ns = clock_ns
        self._read_ns: int | None = None
        self.usual_language = ""

    def name(self) -> str:
        """The clinic's name as reports print it, "" where none was given."""
        return self._kept(NAME_KEY)

    def set_name(self, actor: Account, name: str) -> None:
        """Give the clinic another name (verb "manage_users").

        Raises:
            Refused: The actor may not, the name is too long or holds what cannot be shown.
        """
        require(actor, "manage_users")
        kept = one_line("clinic's name", name, LONGEST_NAME)
        self._keep(actor, NAME_KEY, kept, "set clinic name")

    def language(self) -> str:
        """Code of the language for whoever has not chosen one, "" for the one that the browser asks for.

        What another station of the clinic set is known within seconds.
        """
        now_ns = self._clock_ns()
        if self._read_ns is None or now_ns - self._read_ns > _FRESH_NS:
            self.usual_language, self._read_ns = self._kept(LANGUAGE_KEY), now_ns
        return self.usual_language

    def set_language(self, actor: Account, code: str, known: tuple[str, ...]) -> None:
        """Choose it (verb "manage_users").

        Args:
            actor: Who chooses.
            code: Such as "it"; "" for the one that each browser asks for.
            known: Codes that the pages speak.

        Raises:
            Refused: The actor may not, or the pages do not speak it.
        """
        require(actor, "manage_users")
        if code and code not in known:
            raise Refused(
                "language", repr(code[:20]), "one of " + ", ".join(known), "choose it from the list"
            )
        self._keep(actor, LANGUAGE_KEY, code, "set language")
        self.usual_language, self._read_ns = code, self._clock_ns()

    def _kept(self, key: str) -> str:
        kept = self._catalogue.setting(key)
        return "" if kept is None else msgspec.json.decode(kept.content, type=str)

    def _keep(self, actor: Account, key: str, value: str, verb: str) -> None:
        self._catalogue.set(Setting(key=key, content=msgspec.json.encode(value).decode(), by=actor.name))
        self._audit.note(actor, verb, "", value or "none")
