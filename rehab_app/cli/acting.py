"""Who acts at the console: the console itself, or the account that it names."""

from __future__ import annotations

from rehab_app.access import CONSOLE, Account
from rehab_app.services.clinic import Clinic


def acting(clinic: Clinic, by: str) -> Account:
    """The account named with ``--by``; the console where nobody is named.

    Raises:
        Refused: Accounts exist and none has that name.
    """
    return clinic.accounts.at_console(by) if by else CONSOLE
