"""The log says what the server does and never who a patient is; whoever logs waits for nothing."""

from __future__ import annotations

import json
import logging
import os
import threading

import pytest

from rehab_app.config import LogSettings
from rehab_app.errors import Refused
from rehab_app.services.patients import Patients
from rehab_app.web.server_log import logging_to, request_id, tell

from .test_matrix import VERBS, path_of, routes

GIVEN, FAMILY, BORN = "Quirinius", "Xylophonski", "1931-07-29"
NOTE = "afraid of the thunderous zeppelin"
SECRETS = (GIVEN, FAMILY, BORN, NOTE, "zeppelin", "xylophonski")


@pytest.fixture
def log(tmp_path):
    return tmp_path / "server.log"


def lines(log):
    return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]


def test_a_whole_run_of_pages_leaves_no_identity_in_the_log(app, browser, log, monkeypatch):
    person = {"given_name": GIVEN, "family_name": FAMILY, "birth_date": BORN, "side": "left"}
    person |= {"hand_length_cm": "18.9", "impairment": NOTE}
    with logging_to(LogSettings(level="debug", file=str(log)), "room-2"):
        therapist, administrator = browser("therapist"), browser("administrator")
        patient = therapist.post("/patients", **person).headers["location"].split("/")[2].split("?")[0]
        assert therapist.post("/patients", **person | {"birth_date": f"{BORN}-{NOTE}"}).status_code < 500
        therapist.post(f"/patients/{patient}/journal/note", text=NOTE)
        assert FAMILY in therapist.get(f"/patients?find={FAMILY}").text
        therapist.get(f"/{GIVEN}/{FAMILY}?note={NOTE}", referer=f"http://localhost/patients?find={FAMILY}")
        therapist.send(GIVEN, "/patients")
        browser().post("/sign-in", name=FAMILY, password=NOTE)
        for line in sorted(set(VERBS) & routes(app)):
            if line.startswith("GET ") and "{patient}" in line:
                administrator.get(path_of(line).replace("P-9999", patient) + f"?q={GIVEN}&from={BORN}")
        fail_as_the_server_does(therapist, monkeypatch)
    text = log.read_text(encoding="utf-8")
    told = lines(log)
    assert not [secret for secret in SECRETS if secret.casefold() in text.casefold()]
    assert patient not in text
    assert {"/patients", "/patients/{patient}", "none"} <= {line.get("route") for line in told}
    assert all({"utc", "level", "event", "station"} <= set(line) for line in told)
    failed = next(line for line in told if "error" in line)
    assert failed["error"] == "RuntimeError"
    assert "Traceback: " in failed["trace"]


def fail_as_the_server_does(visitor, monkeypatch):
    def fails(*_, **__):
        raise RuntimeError(f"INSERT INTO patients VALUES ({GIVEN!r}, {NOTE!r})")

    monkeypatch.setattr(Patients, "get", fails)
    monkeypatch.setattr(Patients, "search", fails)
    with pytest.raises(RuntimeError) as raised:
        visitor.get(f"/patients?find={FAMILY}")
    uvicorn = logging.getLogger("uvicorn.error")
    uvicorn.error("Exception in ASGI application\n", exc_info=raised.value)
    uvicorn.warning("%s of %s is gone", GIVEN, FAMILY)


def test_a_request_has_an_id_a_time_and_a_route(app, browser, log):
    with logging_to(LogSettings(level="info", file=str(log)), "room-2"):
        answer = browser("therapist").get("/patients/P-9999")
        browser().get("/stop/state")
    (line,) = lines(log)  # what pages ask every second is not told at this level
    assert line["request"] == answer.headers["x-request-id"]
    assert (line["route"], line["method"], line["status"]) == (
        "/patients/{patient}",
        "GET",
        answer.status_code,
    )
    assert line["duration_s"] > 0
    assert line["utc"].endswith("+00:00")
    assert line["station"] == "room-2"
    assert request_id.get() == ""


def test_text_for_a_person_and_the_level(log):
    with logging_to(LogSettings(level="warning", format="text", file=str(log)), "room-2"):
        tell("quiet")
        tell("loud", logging.ERROR, rows=3)
    (line,) = log.read_text(encoding="utf-8").splitlines()
    assert line.endswith("error loud rows=3")


def test_the_logging_of_the_process_is_as_before_afterwards(log):
    root = logging.getLogger()
    before = (root.handlers[:], root.level)
    with logging_to(LogSettings(file=str(log)), "x"):
        assert root.handlers != before[0]
    assert (root.handlers, root.level) == before


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    with (
        pytest.raises(Refused, match=r"log\.file"),
        logging_to(LogSettings(file=str(tmp_path / "no" / "x")), ""),
    ):
        pass


def test_a_pipe_that_nobody_reads_holds_nobody_up(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    told = threading.Event()
    with logging_to(LogSettings(level="info", file=str(pipe)), "x"):

        def many():
            for number in range(3000):  # several times what a pipe holds
                tell("event", number=number, filling="x" * 100)
            told.set()

        threading.Thread(target=many, daemon=True).start()
        assert told.wait(30.0)
        os.close(reading)  # lets the writer go
