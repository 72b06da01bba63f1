"""Roles and the verbs that each may use: one table, read by every service."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from rehab_app.errors import Refused

Role: TypeAlias = Literal["administrator", "therapist", "assistant", "patient", "auditor"]
Verb: TypeAlias = Literal[
    "view",
    "note",
    "record",
    "approve",
    "prescribe",
    "play",
    "stop",
    "clear_stop",
    "export",
    "erase",
    "backup",
    "manage_users",
    "audit",
]
ROLES: tuple[Role, ...] = get_args(Role)
VERBS: tuple[Verb, ...] = get_args(Verb)

# In a small practice the person who sets the clinic up also treats, so an administrator may do everything;
# every use is in the audit chain. "stop" is here only so that the table is whole: nobody is asked for it.
_MAY: dict[Role, frozenset[Verb]] = {
    "administrator": frozenset(VERBS),
    "therapist": frozenset(
        ("view", "note", "record", "approve", "prescribe", "play", "stop", "clear_stop", "export")
    ),
    "assistant": frozenset(("view", "note", "record", "play", "stop")),
    "patient": frozenset(("stop",)),
    "auditor": frozenset(("view", "stop", "audit")),
}


@dataclass(frozen=True, slots=True)
class Account:
    """Somebody who has signed in, or the person at the console.

    Attributes:
        name: Sign-in name.
        role: Role, one of ROLES.
        id: Catalogue id as text; "console" for the command line.
    """

    name: str
    role: Role
    id: str

    def may(self, verb: Verb) -> bool:
        """Whether the role may use the verb."""
        return verb in _MAY[self.role]


CONSOLE = Account("console", "administrator", "console")
"""Whoever runs commands on the clinic's own machine: the folder's permissions are the sign-in."""


def require(account: Account, verb: Verb) -> None:
    """Let the account pass or refuse.

    Raises:
        Refused: The account's role may not use the verb.
    """
    if account.may(verb):
        return
    allowed = ", ".join(role for role in ROLES if verb in _MAY[role])
    raise Refused(
        f"the role of {account.name}",
        f"{account.role}, which may not {verb.replace('_', ' ')}",
        f"one of {allowed}",
        "ask a colleague with that role to do it",
    )


def role_named(name: str) -> Role:
    """The role of that name.

    Raises:
        Refused: There is none.
    """
    for role in ROLES:
        if role == name:
            return role
    raise Refused("role", repr(name), "one of " + ", ".join(ROLES), "choose a role")
