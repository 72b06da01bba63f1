"""Accounts: set-up, sign-in, roles, passwords."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

from rehab_app.access import CONSOLE, Account, RateLimit, Verb, hash_password, require, verify_password
from rehab_app.access.roles import role_named
from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.audit import Audit
from rehab_app.services.own_patients import OwnPatients
from rehab_app.services.sign_ins import SignIns
from sessions.catalogue import Catalogue, User

_FAILURES = 5
_WINDOW_S = 60.0  # short: whoever is locked out by a stranger's guesses must soon be able to clear a stop
_NAME_LONGEST = 60
_ADMINISTRATOR = "administrator"


class Accounts:
    """The people who may sign in.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where sign-ins and changes are noted.

    Attributes:
        sign_ins: Their sign-ins.
        own_patients: Whose screen an account of the role patient is.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._limit = RateLimit(_FAILURES, _WINDOW_S, time.monotonic)
        self._decoy = ""
        self._last: dict[str, User] = {}
        self._changing = threading.Lock()  # two administrators must not demote each other at one moment
        self.sign_ins = SignIns(catalogue)
        self.own_patients = OwnPatients(catalogue, audit)

    def set_up_needed(self) -> bool:
        """Whether nobody has an account yet, so that the first one becomes the administrator."""
        return not self._catalogue.users()

    def set_up(self, name: str, password: str) -> Account:
        """Make the first account, the administrator's.

        Raises:
            Refused: Somebody has an account already, or as of ``add_user``.
        """
        with self._changing:
            if not self.set_up_needed():
                raise Refused("first account", "made already", "made once", "sign in")
            return self.add_user(name, _ADMINISTRATOR, password, CONSOLE)

    def sign_in(self, name: str, password: str) -> Account:
        """The account of that name and password.

        Raises:
            Refused: Name or password are wrong (which of them is not said), or too many tries.
        """
        user = self._proven(name, password)
        account = _account(user)
        self._audit.note(account, "sign in")
        return account

    def unlock(self, name: str, password: str) -> Account:
        """The same for a page that was covered while nobody used it.

        Raises:
            Refused: As of ``sign_in``.
        """
        account = _account(self._proven(name, password, again=True))
        self._audit.note_later(account.name, "unlock")
        return account

    def account(self, name: str) -> Account:
        """The active account of that name (a signed cookie carries only the name).

        While the catalogue does not answer, somebody who is signed in goes on as known last.

        Raises:
            Refused: There is none, or it is closed.
        """
        user = self._find_again(name)
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

    def add_user(self, name: str, role: str, password: str, actor: Account, patient: str = "") -> Account:
        """Make an account; with the role patient it may be one patient's screen, by pseudonym.

        Raises:
            Refused: The actor may not, the name is taken or empty, the password too short, the role unknown,
                or the patient is unknown or given with another role.
        """
        require(actor, "manage_users")
        kept = _name(name)
        known = role_named(role)
        own = self.own_patients.check(known, patient)
        taken = next((one.name for one in self._catalogue.users() if _same(one.name, kept)), None)
        if taken is not None:
            raise Refused(f"user {kept}", f"already there as {taken}", "a new name", "choose another name")
        hashed = hash_password(password)
        user = self._catalogue.add_user(User(name=kept, role=known, password_hash=hashed))
        self._audit.note(actor, "add user", user.name, known)
        self.own_patients.tie(_account(user), own, actor)
        return _account(user)

    def list(self, actor: Account) -> tuple[Account, ...]:
        """All active accounts.

        Raises:
            Refused: The actor may not manage users.
        """
        require(actor, "manage_users")
        return tuple(_account(user) for user in self._catalogue.users() if user.active)

    def closed(self, actor: Account) -> tuple[str, ...]:
        """Names of closed accounts: they stay taken, so that the audit means one person by a name.

        Raises:
            Refused: The actor may not manage users.
        """
        require(actor, "manage_users")
        return tuple(user.name for user in self._catalogue.users() if not user.active)

    def change_role(self, name: str, role: str, actor: Account, patient: str = "") -> Account:
        """Give an account another role, or another patient; it is signed out everywhere.

        Raises:
            Refused: The actor may not, account, role or patient are unknown, the patient is given with
                another role, or it is the last administrator.
        """
        require(actor, "manage_users")
        known = role_named(role)
        own = self.own_patients.check(known, patient)
        with self._changing:
            user = self._active(name)
            if known != _ADMINISTRATOR:
                self._keep_one_administrator(user)
            changed = self._catalogue.change_user(replace(user, role=known))
            self.own_patients.tie(_account(changed), own, actor)
        self.sign_ins.end_all(user.name)
        self._audit.note(actor, "change role", user.name, f"{user.role} to {known}")
        return _account(changed)

    def reset_password(self, name: str, password: str, actor: Account) -> None:
        """Give an account a new password; it is signed out everywhere.

        Raises:
            Refused: The actor may not, the account is unknown, or the password too short.
        """
        require(actor, "manage_users")
        self._set_password(self._active(name), password)
        self._audit.note(actor, "reset password", name)

    def change_password(self, actor: Account, old: str, new: str) -> None:
        """Change one's own password; every sign-in of it ends, this one too.

        Raises:
            Refused: The old password is wrong, the new one the same or too short, or too many tries.
        """
        user = self._proven(actor.name, old)
        if old == new:
            raise Refused("new password", "the old one", "another one", "choose another")
        self._set_password(user, new)
        self._audit.note(actor, "change password", actor.name)

    def close(self, name: str, actor: Account) -> None:
        """Close an account: it is signed out everywhere and can sign in no more.

        Raises:
            Refused: The actor may not, the account is unknown, or it is the last administrator.
        """
        require(actor, "manage_users")
        with self._changing:
            user = self._active(name)
            self._keep_one_administrator(user)
            self._catalogue.change_user(replace(user, active=False))
        self.sign_ins.end_all(user.name)
        self._audit.note(actor, "close account", user.name)

    def set_idle_lock(self, minutes: int, actor: Account) -> None:
        """Change after how many minutes without use a page is covered.

        Raises:
            Refused: The actor may not, or the time is out of bounds.
        """
        require(actor, "manage_users")
        self.sign_ins.set_idle_s(60 * minutes, actor.name)
        self._audit.note(actor, "set idle lock", "", f"{minutes} minutes")

    def require(self, account: Account, verb: Verb) -> None:
        """Refuse when the account's role may not use the verb."""
        require(account, verb)

    def _proven(self, name: str, password: str, *, again: bool = False) -> User:
        key = name.strip().casefold()
        self._limit.check(key)
        user = self._find_again(name.strip()) if again else self._find(name.strip())
        # an unknown name costs as much time as a wrong password, so that names cannot be found by the clock
        matches = verify_password(user.password_hash if user else self._no_hash(), password)
        if user is None or not user.active or not matches:
            self._limit.fail(key)
            self._audit.note_later("unnamed", "sign-in refused")
            raise Refused(
                "sign-in", "wrong", "the name and password of an account", "check both and try again"
            )
        self._limit.succeed(key)
        return user

    def _set_password(self, user: User, password: str) -> None:
        self._catalogue.change_user(replace(user, password_hash=hash_password(password)))
        self.sign_ins.end_all(user.name)

    def _keep_one_administrator(self, user: User) -> None:
        others = [
            one
            for one in self._catalogue.users()
            if one.active and one.role == _ADMINISTRATOR and one.name != user.name
        ]
        if user.role == _ADMINISTRATOR and not others:
            raise Refused(
                f"user {user.name}", "the last administrator", "one of several", "make another one first"
            )

    def _active(self, name: str) -> User:
        user = self._find(name.strip())
        if user is None or not user.active:
            raise Refused(f"user {name.strip()[:60]!r}", "unknown or closed", "an account", "choose another")
        return user

    def _find(self, name: str) -> User | None:
        return next((user for user in self._catalogue.users() if user.name == name), None)

    def _find_again(self, name: str) -> User | None:
        """Somebody who was looked up before; as known then, where the catalogue does not answer."""
        try:
            user = self._find(name)
        except NoAnswer:
            if name not in self._last:
                raise
            return self._last[name]
        if user is not None:
            self._last[name] = user
        return user

    def _no_hash(self) -> str:
        if not self._decoy:
            self._decoy = hash_password("nobody has this password")
        return self._decoy


def _same(one: str, other: str) -> bool:
    return one.casefold() == other.casefold()


def _name(text: str) -> str:
    """A sign-in name that a screen can show and an audit row can hold."""
    kept = text.strip()
    if not 1 <= len(kept) <= _NAME_LONGEST:
        bound = f"1 to {_NAME_LONGEST} characters"
        raise Refused("user name", f"{len(kept)} characters long", bound, "choose another name")
    if not kept.isprintable():
        raise Refused("user name", repr(kept), "letters that can be shown", "choose another name")
    return kept


def _account(user: User) -> Account:
    return Account(user.name, role_named(user.role), str(user.id))
