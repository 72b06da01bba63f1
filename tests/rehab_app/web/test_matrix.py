"""Every route by every role, written down a second time: a route without a line here fails."""

from __future__ import annotations

import msgspec
import pytest
from starlette.routing import Mount, Route, WebSocketRoute
from viser import _messages

from rehab_app.access import ROLES, Account
from rehab_app.web.gateway.messages import let_through
from rehab_app.web.policy import ALWAYS

from .test_messages import CAMERA, VALUE

# Nobody needs to be signed in for these; each has a test of its own.
OPEN = {
    "GET /",
    "GET /sign-in",
    "POST /sign-in",
    "GET /set-up",
    "POST /set-up",
    "POST /unlock",
    "GET /here",
    "POST /language",
    "POST /stop",
    "GET /stop/state",
    "GET /healthz",
    "GET /healthz/live",
    "GET /metrics",
}
# Behind sign-in and role by the gateway's own check: tests/rehab_app/web/test_gateway.py.
GATEWAY = {"GET /live/view/", "GET /review/{recording}/view/"}
SOCKETS = {"/live/view", "/review/{recording}/view"}
TABLE = {
    "stop": """
        POST /sign-out; POST /here; GET /kept; POST /kept/drop; GET /mine; GET /mine/state; GET /account
        POST /account/password; POST /account/sign-out; GET /clinic; POST /live/pause; POST /live/speed
        POST /live/pain
    """,
    "clear_stop": "POST /stop/clear",
    "manage_users": """
        GET /clinic/users; POST /clinic/users; POST /clinic/users/role; POST /clinic/users/password
        POST /clinic/users/close; POST /clinic/users/idle
        GET /clinic/settings; POST /clinic/settings/name; POST /clinic/settings/language
        POST /clinic/settings/idle; POST /clinic/settings/retention; POST /clinic/settings/aim
    """,
    "audit": "GET /clinic/audit; GET /clinic/audit.csv",
    "view": """
        GET /live; GET /live/takes; GET /live/patients; POST /live/beat; GET /live/limits
        GET /live/session/choices; GET /patients
        GET /patients/{patient}; GET /patients/{patient}/diagnosis; POST /patients/{patient}/lock
        GET /patients/{patient}/limits; GET /patients/{patient}/outcomes; GET /patients/{patient}/journal
        GET /patients/{patient}/assessments
        GET /patients/{patient}/sessions; GET /patients/{patient}/data; GET /patients/{patient}/plan
        GET /patients/{patient}/progress; GET /patients/{patient}/progress.{format}
        GET /patients/{patient}/compare; GET /patients/{patient}/compare.{format}
        GET /patients/{patient}/next
        GET /exercises; GET /exercises/{name:path}; GET /exercise-pictures/{name}/{view}/{side}.svg
        GET /takes; GET /takes/{recording}; GET /takes/{recording}/compare
        GET /takes/{recording}/joints/{which}.svg; GET /takes/{recording}/report
        GET /takes/{recording}/report.html; GET /takes/{recording}/report.json
        GET /takes/{recording}/report.{format}; GET /sessions; GET /sessions/{recording}
        GET /sessions/{recording}/report; GET /sessions/{recording}/report.html
        GET /sessions/{recording}/report.json; GET /sessions/{recording}/report.{format}
        GET /clinic/stations
        GET /clinic/devices; GET /clinic/calibration; GET /clinic/calibration/board.{kind}; GET /help
    """,
    "note": """
        POST /live/session/check-in; POST /live/session/end; GET /live/session/note
        POST /patients/{patient}/outcomes; POST /patients/{patient}/journal/note
        POST /patients/{patient}/journal/pain; POST /patients/{patient}/journal/event
        POST /patients/{patient}/data/consent; POST /patients/{patient}/plan/item
        POST /patients/{patient}/plan/move; POST /patients/{patient}/plan/frame
        POST /takes/{recording}/withdraw
    """,
    "record": """
        GET /live/cameras; POST /live/record; POST /live/finish; POST /takes/{recording}/retouch
        GET /takes/{recording}/names; POST /takes/{recording}/names; GET /takes/{recording}/first.jpg
    """,
    "play": """
        POST /live/play; POST /live/measure; POST /live/fit; POST /live/tone; POST /live/tracking
        POST /live/resume; POST /live/reverse; POST /live/next; POST /live/target; POST /live/operate
        POST /live/session/begin; POST /live/session/step; POST /live/session/start
    """,
    "approve": "POST /takes/{recording}/approve",
    "prescribe": """
        POST /patients; GET /patients/new; GET /patients/{patient}/edit; POST /patients/{patient}/edit
        POST /patients/{patient}/archive; POST /patients/{patient}/unarchive
        POST /patients/{patient}/diagnosis; POST /patients/{patient}/unlock; POST /exercises; GET /prescribe
        POST /patients/{patient}/next; POST /patients/{patient}/aim
    """,
    "backup": """
        GET /clinic/backup; POST /clinic/backup/passphrase; POST /clinic/backup/place
        POST /clinic/backup/make
        POST /clinic/backup/restore; GET /clinic/backup/file/{name}
    """,
    "erase": """
        POST /clinic/backup/retention; POST /patients/{patient}/data/images
        POST /patients/{patient}/data/erase
    """,
    "export": "POST /patients/{patient}/data/export",
}
VERBS = {
    line.strip(): verb
    for verb, lines in TABLE.items()
    for row in lines.splitlines()
    for line in row.split(";")
    if line.strip()
}
FILLED = {"{name:path}": "none", "{patient}": "P-9999", "{recording}": "0" * 8}


def routes(app):
    return {
        f"{method} {route.path}"
        for route in app.routes
        if isinstance(route, Route)
        for method in (route.methods or set()) - {"HEAD"}
    }


def path_of(line):
    path = line.split(" ", 1)[1]
    for part, value in FILLED.items():
        path = path.replace(part, value)
    return path.replace("{", "").replace("}", "")


def asked(visitor, line):
    if line.startswith("GET "):
        return visitor.send("GET", path_of(line), headers={"accept": "application/json"})
    return visitor.ask(path_of(line))


def test_every_route_has_a_line(app):
    known = set(VERBS) | OPEN | GATEWAY
    assert routes(app) - known == set(), "add the new routes to the table, and think who may use them"
    assert {route.path for route in app.routes if isinstance(route, WebSocketRoute)} == SOCKETS
    assert [route.path for route in app.routes if isinstance(route, Mount)] == ["/static"]


@pytest.mark.parametrize("line", sorted(VERBS))
def test_a_route_asks_for_sign_in_and_role(app, browser, clinic, line):
    if line not in routes(app):
        pytest.skip("not built in this version")
    assert asked(browser(), line).status_code == 401
    try:
        for role in ROLES:
            refused = asked(browser(role), line).status_code == 403
            assert refused == (not Account(role, role, "1").may(VERBS[line])), role
    finally:
        clinic.live.clear_stop(Account("therapist", "therapist", "1"), confirmed=True)


@pytest.mark.parametrize("line", sorted(key for key in VERBS if key.startswith("POST ")))
def test_a_form_needs_the_token_of_its_sign_in(app, browser, line):
    if line not in routes(app):
        pytest.skip("not built in this version")
    visitor, other = browser("administrator"), browser("administrator")
    for token in ("", "guess", other.token):
        visitor.token = token
        assert asked(visitor, line).status_code == 403


@pytest.mark.parametrize("line", sorted(key for key in {*VERBS, *OPEN} if key.startswith("POST ")))
def test_no_action_comes_from_another_site(app, browser, clinic, line):
    if line not in routes(app):
        pytest.skip("not built in this version")
    answer = browser("administrator").post(path_of(line), origin="https://evil.example")
    assert answer.status_code == 403
    assert not clinic.live.snapshot().stop_source


@pytest.mark.parametrize("line", sorted(key for key in {*VERBS, *OPEN} if key.startswith("GET ")))
def test_every_answer_carries_the_security_headers(app, browser, line):
    if line not in routes(app):
        pytest.skip("not built in this version")
    answer = browser("administrator").get(path_of(line))
    assert answer.status_code < 500 or line == "GET /healthz"  # no server has opened this clinic
    for name, value in ALWAYS.items():
        assert answer.headers[name] == value
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe-eval" not in policy
    assert "frame-ancestors" in policy


@pytest.mark.parametrize("attack", ["..%2f..%2fsecret", "%2e%2e", "x%0d%0aset-cookie:a=b", "%00", "ü" * 300])
def test_no_path_leads_out_or_into_a_header(app, browser, attack):
    visitor = browser("administrator")
    for line in sorted(set(VERBS) & routes(app)):
        if line.startswith("GET ") and "{" in line:
            path = path_of(line).replace("P-9999", attack).replace("0" * 8, attack)
            for part in ("name", "format", "kind", "which", "none"):
                path = path.replace(f"/{part}", f"/{attack}").replace(f".{part}", f".{attack}")
            answer = visitor.get(path)
            assert answer.status_code in (303, 400, 404), path
            assert not any("a=b" in value for value in answer.headers.get_list("set-cookie"))


@pytest.mark.parametrize("role", ROLES)
def test_every_message_of_the_viewport_by_every_role(role):
    kinds = {kind.__name__ for kind in _messages.Message.get_subclasses()}
    plays = Account(role, role, "1").may("play")
    passed = {
        kind
        for kind in kinds
        if let_through(msgspec.msgpack.encode({**CAMERA, **VALUE, "type": kind}), plays) is not None
    }
    assert passed == {"ViewerCameraMessage"} | ({"GuiUpdateMessage"} if plays else set())
