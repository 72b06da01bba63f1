"""A clinic with one account for each role, a take, and a patient whose name is an attack."""

from __future__ import annotations

import asyncio

import httpx
import pytest

from rehab_app.access import CONSOLE, ROLES
from rehab_app.bootstrap import open_clinic
from rehab_app.web import create_app
from rehab_app.web.visit import COOKIE

PASSWORD = "correct horse battery"
ATTACK = "<img src=x onerror=alert(1)>"
ORIGIN = "http://localhost"


class NoPictures:
    """Viewports for tests that never look at one."""

    def live_port(self):
        raise AssertionError("no test here looks at the live picture")

    def review_port(self, recording):
        raise AssertionError(f"no test here reviews {recording}")

    def close(self):
        pass


@pytest.fixture(scope="session")
def clinic(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("clinic")) as opened:
        for role in ROLES:
            opened.accounts.add_user(role, role, PASSWORD, CONSOLE)
        opened.patients.add(
            CONSOLE, given_name=ATTACK, family_name="O'Hara & Sons", birth_date="1957-03-14", side="left"
        )
        for seed in (3, 4):
            opened.takes.record_virtual("open_close", "right", 1.5, seed, CONSOLE)
        yield opened


@pytest.fixture(scope="session")
def app(clinic):
    return create_app(clinic, open_viewports=lambda _: NoPictures())


@pytest.fixture
def stop_cleared(clinic):
    """Leaves the clinic's stop released."""
    yield
    clinic.live.clear_stop(CONSOLE, confirmed=True)


@pytest.fixture
def take(clinic):
    return clinic.takes.list()[0].id


@pytest.fixture
def unseen_take(clinic):
    """A take that one test approves and no other touches."""
    return clinic.takes.list()[1].id


@pytest.fixture
def patient(clinic):
    return clinic.patients.list()[0].id


class Browser:
    """Somebody's browser at the clinic: each request runs through the whole application.

    ``post`` sends what the pages' forms send: the Origin and the form token of the sign-in.
    """

    def __init__(self, app, role=None, address="192.0.2.7"):
        self.app = app
        self.address = address
        self.cookies = httpx.Cookies()
        self.token = ""
        if role is not None:
            seal = app.state.site.seal
            cookie = app.state.site.begin(role)
            self.cookies.set(COOKIE, cookie, domain="localhost.local", path="/")
            self.token = seal.form_token(seal.read(cookie))

    def send(self, method, path, **content):
        async def answered():
            transport = httpx.ASGITransport(self.app, client=(self.address, 50000))
            async with httpx.AsyncClient(
                transport=transport, base_url=ORIGIN, cookies=self.cookies
            ) as client:
                answer = await client.request(method, path, **content)
                self.cookies = client.cookies
                return answer

        return asyncio.run(answered())

    def get(self, path, **headers):
        return self.send("GET", path, headers=headers)

    def post(self, path, origin=ORIGIN, **fields):
        headers = {"origin": origin} if origin else {}
        return self.send("POST", path, data={"form_token": self.token, **fields}, headers=headers)

    def ask(self, path, **fields):
        """As the page's script does: JSON back."""
        headers = {"origin": ORIGIN, "accept": "application/json", "x-form-token": self.token}
        return self.send("POST", path, data=fields, headers=headers)


@pytest.fixture
def browser(app):
    def opened(role=None, **where):
        return Browser(where.pop("app", app), role, **where)

    return opened
