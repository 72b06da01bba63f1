"""Paths of access: unlock, what was kept, the own account, users, audit, the patient's screen, the clinic."""

from __future__ import annotations

from collections.abc import Callable

from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from rehab_app.access import Verb
from rehab_app.web.pages import audit, clinic_home, entry, help, kept, mine, own_account, settings, users
from rehab_app.web.visit import Visit, action, page


def access_routes() -> list[BaseRoute]:
    """The routes."""

    def shows(path: str, answer: Callable[[Visit], Response], verb: Verb = "view") -> BaseRoute:
        return Route(path, page(answer, verb), methods=["GET"])

    def does(path: str, answer: Callable[[Visit], Response], verb: Verb, back: str) -> BaseRoute:
        return Route(path, action(answer, verb, back), methods=["POST"])

    return [
        Route("/unlock", entry.unlock, methods=["POST"]),
        Route("/here", entry.here, methods=["GET"]),
        does("/here", entry.still_here, "stop", "/"),
        shows("/kept", kept.kept, "stop"),
        does("/kept/drop", kept.drop, "stop", "/"),
        shows("/mine", mine.mine, "stop"),
        shows("/mine/state", mine.state, "stop"),
        shows("/account", own_account.account, "stop"),
        does("/account/password", own_account.change_password, "stop", "/account"),
        does("/account/sign-out", own_account.sign_out_everywhere, "stop", "/account"),
        shows("/clinic", clinic_home.home, "stop"),
        shows("/help", help.guide),
        shows("/clinic/users", users.users, "manage_users"),
        does("/clinic/users", users.add, "manage_users", users.PAGE),
        does("/clinic/users/role", users.change_role, "manage_users", users.PAGE),
        does("/clinic/users/password", users.reset_password, "manage_users", users.PAGE),
        does("/clinic/users/close", users.close, "manage_users", users.PAGE),
        does("/clinic/users/idle", users.set_idle_lock, "manage_users", users.PAGE),
        shows(settings.PAGE, settings.settings, "manage_users"),
        *(
            does(f"{settings.PAGE}/{kind}", settings.change(kind), "manage_users", settings.PAGE)
            for kind in settings.KINDS
        ),
        shows("/clinic/audit", audit.audit, "audit"),
        shows("/clinic/audit.csv", audit.download, "audit"),
    ]
