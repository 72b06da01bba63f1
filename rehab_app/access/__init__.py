"""Who may do what: password hashes, roles and their verbs, and the brake on guessing."""

from rehab_app.access.passwords import hash_password, verify_password
from rehab_app.access.rate import RateLimit
from rehab_app.access.roles import CONSOLE, ROLES, VERBS, Account, Role, Verb, require

__all__ = [
    "CONSOLE",
    "ROLES",
    "VERBS",
    "Account",
    "RateLimit",
    "Role",
    "Verb",
    "hash_password",
    "require",
    "verify_password",
]
