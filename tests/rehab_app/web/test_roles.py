"""Roles are enforced on the server, verb by verb; forms carry the token of their sign-in."""

from __future__ import annotations

import pytest

from rehab_app.access import ROLES
from rehab_app.access.roles import Account

VERBS = {
    "/live/record": "record",
    "/live/finish": "record",
    "/live/play": "play",
    "/live/pause": "stop",
    "/live/resume": "play",
    "/live/speed": "stop",
    "/live/reverse": "play",
    "/live/next": "play",
    "/live/measure": "play",
    "/live/fit": "play",
    "/takes/none/approve": "approve",
    "/takes/none/names": "record",
    "/patients": "prescribe",
    "/stop/clear": "clear_stop",
}
PAGES = {
    "/live": "view",
    "/patients": "view",
    "/patients/new": "prescribe",
    "/takes": "view",
    "/sessions": "view",
}


@pytest.mark.parametrize("role", ROLES)
@pytest.mark.parametrize("path", VERBS)
def test_verbs_ask_for_the_role(browser, role, path):
    status = browser(role).ask(path).status_code
    may = Account(role, role, "1").may(VERBS[path])
    assert (status != 403) == may


@pytest.mark.parametrize("role", ROLES)
@pytest.mark.parametrize("path", PAGES)
def test_pages_ask_for_the_role(browser, role, path):
    answer = browser(role).get(path)
    assert answer.status_code == (200 if Account(role, role, "1").may(PAGES[path]) else 403)


@pytest.mark.parametrize("path", VERBS)
def test_verbs_need_a_sign_in(browser, path):
    assert browser().ask(path).status_code == 401
    assert browser().post(path).headers["location"].startswith("/sign-in")


@pytest.mark.parametrize("path", [*VERBS, "/sign-out", "/live/pain", "/live/beat"])
def test_verbs_need_the_form_token_of_this_sign_in(browser, path):
    visitor, other = browser("administrator"), browser("administrator")
    for token in ("", "guess", other.token):
        visitor.token = token
        assert visitor.ask(path).status_code == 403


def test_a_get_never_acts(browser, take):
    for path in (*VERBS, "/stop", "/sign-out"):
        if path == "/patients":
            continue
        assert browser("administrator").get(path).status_code in (404, 405)
