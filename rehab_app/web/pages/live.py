"""The live page: record, approve, play, hold, and the state that the page shows."""

from __future__ import annotations

import math
from pathlib import Path

from starlette.responses import JSONResponse, Response

from rehab_app.errors import Refused
from rehab_app.services.recording_request import LIVE_KINDS, PROTOCOL, VIRTUAL
from rehab_app.web.live_state import live_state
from rehab_app.web.visit import Visit
from rehab_app.web.words import EXERCISES, MODES, TWINS
from sessions.records import DIGITS

_SECONDS = ("recording length", "a number of seconds")


def live(visit: Visit) -> Response:
    """The page itself: shell panel, viewport, state bar."""
    clinic = visit.site.clinic
    return visit.page(
        "live.html.j2",
        exercises=clinic.takes.exercises(),
        protocols=clinic.takes.protocols(),
        takes=clinic.takes.list(),
        patients=clinic.patients.list(),
        modes=MODES,
        twins=TWINS,
        chosen_patient=visit.request.query_params.get("patient", ""),
        chosen_take=visit.request.query_params.get("take", ""),
    )


def state(visit: Visit) -> Response:
    """What the page shows, four times a second."""
    return JSONResponse(live_state(visit.site, visit.asked("page")))


def beat(visit: Visit) -> Response:
    """The page's heartbeat; only the operator's counts, and only where the account may play."""
    site = visit.site
    if site.operator.is_(visit.asked("page")) and visit.account.may("play"):
        site.clinic.live.operator_beat()
    return state(visit)


def takes(visit: Visit) -> Response:
    """Takes for the two lists of the page, after one was recorded or approved."""
    rows = visit.site.clinic.takes.list()
    return JSONResponse(
        [
            {
                "id": row.id,
                "words": EXERCISES.get(row.exercise, row.exercise),
                "side": row.side,
                "seconds": row.duration_s,
                "approved_by": row.approved_by,
            }
            for row in rows
        ]
    )


def record(visit: Visit) -> Response:
    """Count down and record."""
    visit.site.clinic.live.start_recording(
        visit.account,
        visit.asked("exercise"),
        visit.asked("side"),
        _number(visit, "seconds", *_SECONDS),
        countdown_s=_number(visit, "countdown", "countdown", "a number of seconds"),
        camera=_camera(visit),
        protocol=_protocol(visit),
        person=visit.asked("person"),
        consent_images=visit.asked("consent") == "yes",
    )
    visit.site.operator.take_over(visit.asked("page"))
    return visit.go("/live", "Recording starts after the countdown.")


def cameras(visit: Visit) -> Response:
    """Cameras that can be recorded from, for the list of the page."""
    return JSONResponse(
        [
            {
                "id": one.id,
                "words": one.label,
                "ready": one.state == "ready",
                "state": one.state,
                "has_depth": one.has_depth,
                "remedy": one.remedy,
            }
            for one in visit.site.clinic.takes.cameras()
        ]
    )


def finish(visit: Visit) -> Response:
    """End the recording and keep what there is."""
    visit.site.clinic.live.finish_recording(visit.account)
    return visit.go("/live", "The recording was ended.")


def play(visit: Visit) -> Response:
    """Rehearse, then play. Takes are named by catalogue id only."""
    visit.site.clinic.live.start_therapy(
        visit.account,
        visit.asked("patient") or None,
        _take(visit),
        mode=visit.asked("mode"),
        speed=_number(visit, "speed", "speed", "a number of percent") / 100.0,
        repetitions=_whole(visit, "repetitions"),
        twin=visit.asked("twin"),
    )
    visit.site.operator.take_over(visit.asked("page"))
    return visit.go("/live", "Rehearsing on the virtual twin.")


def pause(visit: Visit) -> Response:
    """Hold the path."""
    visit.site.clinic.live.pause(visit.account)
    return visit.go("/live", "Paused.")


def resume(visit: Visit) -> Response:
    """Go on; the page that resumes is the operator's from now on."""
    visit.site.operator.take_over(visit.asked("page"))
    visit.site.clinic.live.resume(visit.account)
    return visit.go("/live", "Going on.")


def speed(visit: Visit) -> Response:
    """Another path speed, in percent of the therapist's."""
    asked = _number(visit, "speed", "speed", "a number of percent")
    visit.site.clinic.live.set_speed(visit.account, asked / 100.0)
    return visit.go("/live", f"Speed {asked:.0f} %.")


def pain(visit: Visit) -> Response:
    """Pain, by one tap: the run holds."""
    digit = visit.asked("digit")
    if digit and digit not in DIGITS:
        raise Refused("digit", repr(digit[:20]), "one of " + ", ".join(DIGITS), "choose it from the list")
    desk = visit.site.clinic.live
    held = desk.snapshot().state == "playing"
    desk.pain(visit.account, digit)
    return visit.go("/live", "Pain is noted, the movement is held." if held else "Pain is noted.")


def _take(visit: Visit) -> str:
    named = visit.asked("take")
    if not named:
        raise Refused("take", "not chosen", "an approved take", "choose one, or record and approve one first")
    if Path(named).name != named or not named.isalnum():
        raise Refused(f"take {named!r}", "no catalogue id", "letters and digits", "choose it from the list")
    return named


def _camera(visit: Visit) -> str:
    """A camera of the list. A browser never names files, so anything else is refused."""
    named = visit.asked("camera") or VIRTUAL
    if named.partition(":")[0] not in (VIRTUAL, *LIVE_KINDS):
        raise Refused("camera", repr(named[:40]), "a camera of the list", "choose it from the list")
    return named


def _protocol(visit: Visit) -> str:
    """A protocol of the list, for the same reason."""
    named = visit.asked("protocol") or PROTOCOL
    known = [name for name, _ in visit.site.clinic.takes.protocols()]
    if named not in known:
        raise Refused("marker protocol", repr(named[:40]), "one of " + ", ".join(known), "choose it")
    return named


def _number(visit: Visit, name: str, thing: str, bound: str) -> float:
    text = visit.asked(name)
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise Refused(thing, repr(text), bound, "type one")
    return value


def _whole(visit: Visit, name: str) -> int:
    text = visit.asked(name)
    if not (text.isascii() and text.isdecimal() and len(text) <= 6):
        raise Refused(name, repr(text), "a whole number", "type one")
    return int(text)
