"""Accounts: set-up, sign-in, roles."""

from __future__ import annotations

import time

from rehab_app.access import CONSOLE, Account, RateLimit, Verb, hash_password, require, verify_password
from rehab_app.access.roles import role_named
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from sessions.catalogue import Catalogue, User

_FAILURES = 5
_WINDOW_S = 60.0  # short: whoever is locked out by a stranger's guesses must soon be able to clear a stop
_NAME_LONGEST = 60


class Accounts:
    """The people who may sign in.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where sign-ins and changes are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._limit = RateLimit(_FAILURES, _WINDOW_S, time.monotonic)
        self._decoy = ""

    def set_up_needed(self) -> bool:
        """Whether nobody has an account yet, so that the first one becomes the administrator."""
        return not self._catalogue.users()

    def sign_in(self, name: str, password: str) -> Account:
        """The account of that name and password.

        Raises:
            Refused: Name or password are wrong (which of them is not said), or too many tries.
        """
        key = name.strip().casefold()
        self._limit.check(key)
        user = self._find(name.strip())
        # an unknown name costs as much time as a wrong password, so that names cannot be found by the clock
        matches = verify_password(user.password_hash if user else self._no_hash(), password)
        if user is None or not user.active or not matches:
            self._limit.fail(key)
            self._audit.note_later("unnamed", "sign-in refused")
            raise Refused(
                "sign-in", "wrong", "the name and password of an account", "check both and try again"
            )
        self._limit.succeed(key)
        account = _account(user)
        self._audit.note(account, "sign in")
        return account

    def account(self, name: str) -> Account:
        """The active account of that name (a signed cookie carries only the name).

        Raises:
            Refused: There is none, or it is closed.
        """
        user = self._find(name)
        if user is None or not user.active:
            raise Refused(f"user {name!r}", "unknown or closed", "an active account", "sign in again")
        return _account(user)

    def at_console(self, name: str) -> Account:
        """Whoever the person at the console names, as in ``approve --by``.

        Before the first account exists the console vouches for the name; afterwards it must be an account.

        Raises:
            Refused: Accounts exist and none of them has that name, or the name is empty.
        """
        if not name.strip():
            raise Refused("name", "empty", "that of a person", "name who approves with --by")
        if self.set_up_needed():
            return Account(name.strip(), "therapist", CONSOLE.id)
        if self._find(name.strip()) is None:
            known = ", ".join(user.name for user in self._catalogue.users() if user.active)
            raise Refused(
                f"user {name.strip()!r}",
                "unknown",
                f"one of {known}",
                "name one of them, or add the user with rehab-app user add",
            )
        return self.account(name.strip())

    def add_user(self, name: str, role: str, password: str, actor: Account) -> Account:
        """Make an account.

        Raises:
            Refused: The actor may not, the name is taken or empty, the password too short, the role unknown.
        """
        require(actor, "manage_users")
        if not 1 <= len(name.strip()) <= _NAME_LONGEST:
            raise Refused(
                "user name",
                f"{len(name.strip())} characters long",
                f"1 to {_NAME_LONGEST} characters",
                "choose another name",
            )
        known = role_named(role)
        hashed = hash_password(password)
        user = self._catalogue.add_user(User(name=name.strip(), role=known, password_hash=hashed))
        self._audit.note(actor, "add user", user.name, known)
        return _account(user)

    def list(self, actor: Account) -> tuple[Account, ...]:
        """All active accounts.

        Raises:
            Refused: The actor may not manage users.
        """
        require(actor, "manage_users")
        return tuple(_account(user) for user in self._catalogue.users() if user.active)

    def require(self, account: Account, verb: Verb) -> None:
        """Refuse when the account's role may not use the verb."""
        require(account, verb)

    def _find(self, name: str) -> User | None:
        return next((user for user in self._catalogue.users() if user.name == name), None)

    def _no_hash(self) -> str:
        if not self._decoy:
            self._decoy = hash_password("nobody has this password")
        return self._decoy


def _account(user: User) -> Account:
    return Account(user.name, role_named(user.role), str(user.id))
