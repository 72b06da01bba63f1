"""The door: hosts, origins, sizes, headers."""

from __future__ import annotations

import pytest

from rehab_app.web.guard import LARGEST_BODY, known_host, own_names

PAGES = ("/live", "/patients", "/patients/new", "/takes", "/sessions")


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8080", "", "localhost.evil.example", "[::1"])
def test_foreign_names_are_refused(browser, host):
    answer = browser("therapist").get("/patients", host=host)
    assert answer.status_code == 421
    assert "Patients" not in answer.text


@pytest.mark.parametrize("host", ["localhost", "localhost:8080", "127.0.0.1:9", "[::1]:8080", "192.0.2.1"])
def test_own_names_and_addresses_are_known(host):
    assert known_host(host, own_names("127.0.0.1"))


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "null", "", "http://localhost:1", "http://localhost.evil.example"]
)
def test_actions_of_other_sites_are_refused(browser, clinic, take, origin):
    def approvals() -> list[int]:
        return [row.seq for row in clinic.catalogue.audit(10_000) if row.verb == "approve"]

    page = browser("therapist")
    before, written = clinic.takes.approval(take), approvals()  # the clinic is one for all files
    answer = page.post(f"/takes/{take}/approve", origin=origin)
    assert answer.status_code == 403
    assert clinic.takes.approval(take) == before
    assert approvals() == written


@pytest.mark.parametrize("path", PAGES)
def test_every_page_carries_the_security_headers(browser, path):
    answer = browser("therapist").get(path)
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe-inline" not in policy
    assert "unsafe-eval" not in policy
    assert "frame-ancestors 'none'" in policy
    assert answer.headers["x-frame-options"] == "DENY"
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["referrer-policy"] == "same-origin"


@pytest.mark.parametrize("path", PAGES)
def test_pages_obey_their_own_policy(browser, path):
    text = browser("therapist").get(path).text
    assert "<style" not in text
    assert " style=" not in text
    assert " onclick=" not in text
    assert "<script>" not in text


def test_large_bodies_are_refused(browser):
    answer = browser("therapist").post("/patients", impairment="x" * LARGEST_BODY)
    assert answer.status_code == 413


def test_bodies_of_unknown_length_are_refused(browser):
    async def parts():
        yield b"given_name=a"

    answer = browser("therapist").send(
        "POST", "/patients", content=parts(), headers={"origin": "http://localhost"}
    )
    assert answer.status_code == 413


def test_static_files_are_served_and_nothing_beside_them(browser):
    assert browser().get("/static/shell.css").status_code == 200
    assert browser().get("/static/../templates/base.html.j2").status_code == 404
    assert browser().get("/static/%2e%2e/templates/base.html.j2").status_code == 404
