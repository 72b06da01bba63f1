"""Words of roles and of what they may do."""

from __future__ import annotations

from rehab_app.access import Role
from rehab_app.web.language import marked

ROLE_WORDS: dict[Role, str] = {
    "administrator": marked("Administrator"),
    "therapist": marked("Therapist"),
    "assistant": marked("Assistant"),
    "patient": marked("Patient's screen"),
    "auditor": marked("Auditor"),
}
ROLES_MAY: dict[Role, str] = {
    "administrator": marked("everything, and accounts, backups and erasure"),
    "therapist": marked("treats: approves, prescribes, plays, clears the stop, exports"),
    "assistant": marked("records and plays what a therapist approved, writes notes"),
    "patient": marked("sees the own movement, stops, enters pain"),
    "auditor": marked("reads everything and the audit, changes nothing"),
}
