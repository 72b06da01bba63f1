"""What every page shares: the clinic, the key, the templates, the viewports."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Protocol

from jinja2 import Environment

from rehab_app.access import Account, RateLimit
from rehab_app.services.clinic import Clinic
from rehab_app.web.kept_forms import KeptForms
from rehab_app.web.remember import Remembered
from rehab_app.web.signing import Seal
from sessions.catalogue import Patient


class Viewports(Protocol):
    """The pictures: servers on loopback that the gateway reaches."""

    def live_port(self) -> int:
        """Port of the live picture."""
        ...

    def review_port(self, recording: str) -> int:
        """Port of the picture that replays a session or take.

        Raises:
            Refused: There is no such recording, or it is damaged.
        """
        ...

    def close(self) -> None:
        """End them all."""
        ...


class Operator:
    """The one page whose silence holds the motion: the page that started it, or last resumed it."""

    def __init__(self) -> None:
        self._page = ""
        self.name = ""

    def take_over(self, page: str, name: str = "") -> None:
        """Make this page the operator's; ``name`` is who sits before it."""
        self._page, self.name = page, name

    def is_(self, page: str) -> bool:
        """Whether this page is the operator's."""
        return bool(page) and page == self._page


@dataclass(frozen=True, slots=True)
class Site:
    """Everything a page needs.

    Attributes:
        clinic: The clinic.
        seal: Signs and reads tickets.
        templates: Page templates.
        viewports: The pictures.
        sign_in_limit: Brake on guessing, by network address.
        accounts: Active accounts by name, remembered for 2 s.
        patients: Patients by pseudonym, remembered for 10 s.
        kept_forms: What was sent without a sign-in that holds, until its sender has signed in again.
        operator: Whose silence holds the motion.
        signing_in: Password checks at a time are few: each takes 64 MB for a moment.
    """

    clinic: Clinic
    seal: Seal
    templates: Environment
    viewports: Viewports
    sign_in_limit: RateLimit
    accounts: Remembered[Account]
    patients: Remembered[Patient]
    kept_forms: KeptForms = field(default_factory=KeptForms)
    operator: Operator = field(default_factory=Operator)
    signing_in: threading.Semaphore = field(default_factory=lambda: threading.Semaphore(2))

    def begin(self, name: str) -> str:
        """Cookie text of a new sign-in that the server remembers."""
        cookie = self.seal.issue(name)
        ticket = self.seal.read_old(cookie)
        if ticket is not None:
            self.clinic.accounts.sign_ins.begin(name, ticket.digest)
        self.accounts.forget(name)  # the role may be another one since the last sign-in
        return cookie
