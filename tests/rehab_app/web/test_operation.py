"""Health and figures: open to whom they should be, true, cheap, and without anybody's name."""

from __future__ import annotations

import asyncio
import threading
import time
from dataclasses import replace

import pytest
from prometheus_client.parser import text_string_to_metric_families

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import HealthSettings, MetricsSettings
from rehab_app.services.live import LiveDesk
from rehab_app.services.snapshot import LiveSnapshot
from rehab_app.services.tally import ENDING, CountedAudit, cause_of
from rehab_app.web import create_app
from rehab_app.web.health import Doctor
from sessions.catalogue import Catalogue

from .conftest import ATTACK, NoPictures


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("served"), serving=True) as opened:
        yield opened


def app_of(clinic, **settings):
    changed = replace(clinic, settings=replace(clinic.settings, **settings))
    return create_app(changed, open_viewports=lambda _: NoPictures())


def figures(text):
    return {
        (sample.name, *sorted(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def test_a_server_in_order_is_ready_and_says_nothing_about_anybody(served, browser):
    answer = browser(app=app_of(served)).get("/healthz")
    assert answer.status_code == 200
    checks = dict.fromkeys(("catalogue", "disk", "motion", "lease"), True)
    assert answer.json() == {"live": True, "ready": True, "checks": checks}


@pytest.mark.parametrize("check", ["catalogue", "disk", "motion", "lease"])
def test_each_check_alone_makes_it_unready(served, browser, monkeypatch, check):
    clinic = served
    if check == "catalogue":
        monkeypatch.setattr(Catalogue, "setting", broken)
    elif check == "disk":
        health = HealthSettings(free_disk_bytes=2**60)
        clinic = replace(served, settings=replace(served.settings, health=health))
    elif check == "motion":
        health = HealthSettings(heartbeat_s=0.2)
        clinic = replace(served, settings=replace(served.settings, health=health))
        monkeypatch.setattr(LiveDesk, "snapshot", lambda _: LiveSnapshot(state="playing", frame=7))
    else:
        (served.folder / "server.lock").rename(served.folder / "away")
    try:
        answer = browser(app=app_of(clinic)).get("/healthz")
    finally:
        if check == "lease":
            (served.folder / "away").rename(served.folder / "server.lock")
    assert answer.status_code == 503
    assert [name for name, well in answer.json()["checks"].items() if not well] == [check]
    assert browser(app=app_of(clinic)).get("/healthz/live").json() == {"live": True}


def broken(*_):
    raise ZeroDivisionError("the data base is gone")


def test_a_movement_whose_picture_goes_on_is_well(served, monkeypatch):
    frames = iter(range(1000))
    monkeypatch.setattr(LiveDesk, "snapshot", lambda _: LiveSnapshot(state="playing", frame=next(frames)))
    assert asyncio.run(Doctor(served).look()).motion


def test_a_data_base_that_hangs_holds_one_thread_however_often_somebody_asks(served, monkeypatch):
    go, asked = threading.Event(), []

    def hangs(*_):
        asked.append(threading.get_ident())
        go.wait(60.0)

    monkeypatch.setattr(Catalogue, "setting", hangs)
    monkeypatch.setattr("rehab_app.web.health._PATIENCE_S", 0.05)
    monkeypatch.setattr("rehab_app.web.health._KEPT_S", 0.0)

    async def often():
        doctor = Doctor(served)
        try:
            return [await doctor.look() for _ in range(5)]
        finally:
            go.set()

    assert not any(found.catalogue for found in asyncio.run(often()))
    assert len(asked) == 1


def test_many_who_ask_at_once_are_one_look(served, monkeypatch):
    asked = []
    monkeypatch.setattr(Catalogue, "setting", lambda *_: asked.append(1))

    async def many():
        doctor = Doctor(served)
        return await asyncio.gather(*(doctor.look() for _ in range(50)))

    began_s = time.monotonic()
    assert all(found.ready for found in asyncio.run(many()))
    assert len(asked) <= 1 + (time.monotonic() - began_s)


def test_the_figures_count_routes_stops_and_acts_and_name_nobody(app, browser, clinic, patient, stop_cleared):
    therapist = browser("therapist", address="127.0.0.1")
    before = figures(therapist.get("/metrics").text)
    therapist.get(f"/patients/{patient}")
    therapist.post("/stop")
    clinic.audit.note(CONSOLE, "session", "s", "")
    text = therapist.get("/metrics").text
    after = figures(text)

    def grown(name, **labels):
        key = (name, *sorted(labels.items()))
        return after.get(key, 0.0) - before.get(key, 0.0)

    route = "/patients/{patient}"
    assert grown("rehab_requests_total", method="GET", route=route, status="200") == 1
    assert grown("rehab_request_seconds_count", route=route) == 1
    assert grown("rehab_stop_seconds_count") == 1
    assert grown("rehab_stops_total", cause="a person") == 1
    assert grown("rehab_acts_total", verb="session") == 1
    assert after[("rehab_stop_latched",)] == 1
    assert after[("rehab_disk_free_bytes",)] > 0
    assert {"rehab_motion_late_seconds", "rehab_motion_overruns", "rehab_websockets"} <= {
        key[0] for key in after
    }
    for secret in (ATTACK, "O'Hara", "1957-03-14", patient):
        assert secret not in text


def test_made_up_methods_and_paths_are_one_series(app, browser):
    visitor = browser(address="127.0.0.1")
    for number in range(5):
        visitor.send(f"M{number}", f"/made-up-{number}")
    text = visitor.get("/metrics").text
    assert "made-up" not in text
    assert 'method="M' not in text


@pytest.mark.parametrize(
    ("address", "headers", "token", "status"),
    [
        ("127.0.0.1", {}, "", 200),
        ("192.0.2.7", {}, "", 403),
        ("127.0.0.1", {"x-forwarded-for": "127.0.0.1"}, "", 403),
        ("192.0.2.7", {"authorization": "Bearer s3cret"}, "s3cret", 200),
        ("127.0.0.1", {}, "s3cret", 403),
        ("127.0.0.1", {"authorization": "Bearer s3cre"}, "s3cret", 403),
    ],
)
def test_who_may_read_the_figures(clinic, browser, address, headers, token, status):
    app = app_of(clinic, metrics=MetricsSettings(token=token))
    assert browser(app=app, address=address).get("/metrics", **headers).status_code == status


def test_a_queue_can_be_watched(clinic, browser):
    app = app_of(clinic)
    waiting = [1, 2]
    app.state.meters.watch("rehab_any_waiting", "Anything that waits.", lambda: float(len(waiting)))
    visitor = browser(app=app, address="127.0.0.1")
    assert figures(visitor.get("/metrics").text)[("rehab_any_waiting",)] == 2
    waiting.clear()
    assert figures(visitor.get("/metrics").text)[("rehab_any_waiting",)] == 0


def test_a_cause_is_nobody():
    assert cause_of("anna") == cause_of("the safety supervisor's friend") == "a person"
    assert cause_of("the safety supervisor: speed limit") == "the safety supervisor: speed limit"
    assert cause_of(ENDING) == ENDING


def test_rows_are_still_written_and_counted(tmp_path):
    with Catalogue.open(tmp_path) as catalogue:
        audit = CountedAudit(catalogue)
        audit.start()
        audit.note(CONSOLE, "approve")
        audit.note_later("anna", "stop")
        audit.close()
        assert [row.verb for row in reversed(catalogue.audit())] == ["approve", "stop"]
        assert (audit.verbs(), audit.stops()) == ({"approve": 1, "stop": 1}, {"a person": 1})
