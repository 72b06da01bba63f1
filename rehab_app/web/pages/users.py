"""Users of the clinic: add, role, password, close; when an idle page is covered."""

from __future__ import annotations

from collections.abc import Callable

from starlette.responses import Response

from rehab_app.access import ROLES
from rehab_app.errors import Refused
from rehab_app.web.language import _
from rehab_app.web.pages.asked import not_overtaken, whole
from rehab_app.web.visit import Visit
from rehab_app.web.words_access import ROLE_WORDS, ROLES_MAY

PAGE = "/clinic/users"


def users(visit: Visit) -> Response:
    """The page."""
    return _shown(visit, {})


def add(visit: Visit) -> Response:
    """Make an account."""
    name, role = visit.asked("name"), visit.asked("role")
    password = visit.form.get("password", "")
    if password != visit.form.get("again", ""):
        return _shown(visit, {"add": _("The two passwords differ: type the same one twice.")})
    done = _("%(name)s may sign in.") % {"name": name}
    accounts = visit.site.clinic.accounts
    return _do(
        visit,
        "add",
        done,
        lambda: accounts.add_user(name, role, password, visit.account, visit.asked("patient")),
    )


def change_role(visit: Visit) -> Response:
    """Give an account another role."""
    name, accounts = visit.asked("name"), visit.site.clinic.accounts
    done = _("The role of %(name)s was changed; %(name)s signs in again.") % {"name": name}
    role, patient = visit.asked("role"), visit.asked("patient")

    def act() -> None:
        account = accounts.account(name)
        now = f"{account.role} {accounts.own_patients.of(account)}".strip()
        not_overtaken(visit, f"role of {name}", now, f"{role} {patient}".strip())
        accounts.change_role(name, role, visit.account, patient)

    return _do(visit, f"user {name}", done, act)


def reset_password(visit: Visit) -> Response:
    """Give an account a new password."""
    name, accounts = visit.asked("name"), visit.site.clinic.accounts
    password = visit.form.get("password", "")
    done = _("%(name)s has a new password.") % {"name": name}
    return _do(visit, f"user {name}", done, lambda: accounts.reset_password(name, password, visit.account))


def close(visit: Visit) -> Response:
    """Close an account."""
    name, accounts = visit.asked("name"), visit.site.clinic.accounts
    if visit.asked("sure") != "yes":
        return _shown(visit, {f"user {name}": _("Confirm that the account is to be closed.")})
    done = _("The account %(name)s is closed.") % {"name": name}
    return _do(visit, f"user {name}", done, lambda: accounts.close(name, visit.account))


def set_idle_lock(visit: Visit) -> Response:
    """Change when an idle page is covered."""

    def change() -> None:
        minutes = whole(visit, "minutes", "minutes until an idle page is covered")
        not_overtaken(visit, "idle lock", _minutes(visit), f"{minutes}")
        visit.site.clinic.accounts.set_idle_lock(minutes, visit.account)

    return _do(visit, "idle", _("The time was changed."), change)


def _do(visit: Visit, place: str, done: str, act: Callable[[], object]) -> Response:
    """Do it; a refusal stands beside its form, with what was typed."""
    try:
        act()
    except Refused as refusal:
        text = str(refusal)
        return _shown(visit, {place: text[:1].upper() + text[1:] + "."})
    return visit.go(PAGE, done)


def _minutes(visit: Visit) -> str:
    return f"{visit.site.clinic.accounts.sign_ins.idle_s() // 60}"


def _shown(visit: Visit, problems: dict[str, str]) -> Response:
    accounts = visit.site.clinic.accounts
    held = accounts.list(visit.account)
    return visit.page(
        "users.html.j2",
        status=409 if problems else 200,
        accounts=held,
        screens={one.name: accounts.own_patients.of(one) for one in held},
        closed=accounts.closed(visit.account),
        roles=[(role, ROLE_WORDS[role], ROLES_MAY[role]) for role in ROLES],
        problems=problems,
        typed={
            "name": visit.asked("name"),
            "role": visit.asked("role") or "therapist",
            "patient": visit.asked("patient"),
        },
        minutes=_minutes(visit),
        typed_minutes=visit.asked("minutes"),
    )
