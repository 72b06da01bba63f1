"""The patient's own screen: what comes next, stop and pain; name and exercise for the one whose it is."""

from __future__ import annotations

from starlette.responses import JSONResponse, Response

from rehab_app.errors import Refused
from rehab_app.services.snapshot import LiveSnapshot
from rehab_app.web.language import _, marked
from rehab_app.web.render import exercise
from rehab_app.web.visit import Visit

_STEPS = {
    "approach": marked("The robot moves to the start. Let the hand be carried."),
    "ramp": marked("It begins slowly."),
    "cue": marked("Now you: begin the movement."),
    "move": marked("Move with the robot."),
    "hold": marked("Hold it there, and breathe."),
    "return": marked("Back to the start."),
    "rest": marked("Rest the hand."),
    "rest-proposed": marked("Rest the hand for a minute."),
    "skin-check": marked("Your therapist looks at your skin."),
    "done": marked("Done. Well done."),
}
_GOING = marked("Move with the robot.")
_HELD = marked("The movement is held. Nothing moves until your therapist goes on.")
_STOPPED = marked("Stopped. Nothing moves until your therapist clears it.")
_WAITING = marked("Nothing moves. Your therapist begins.")
_READY = marked("It begins in a moment.")


def mine(visit: Visit) -> Response:
    """The page."""
    return visit.page("mine.html.j2", now=_now(visit))


def state(visit: Visit) -> Response:
    """What it shows, once a second."""
    return JSONResponse(_now(visit))


def _now(visit: Visit) -> dict[str, str | bool]:
    now = visit.site.clinic.live.snapshot()
    own = _own(visit, now.patient_id)
    return {
        "name": _given_name(visit, now.patient_id) if own else "",
        "exercise": _exercise(visit, now.take_id) if own else "",
        "step": _step(now),
        "going": now.state == "playing" and not now.paused,
        "count": _count(now),
    }


def _own(visit: Visit, pseudonym: str) -> bool:
    """Whether it is the screen of the patient who practises; anybody else's shows nothing personal."""
    return bool(pseudonym) and visit.site.clinic.accounts.own_patients.of(visit.account) == pseudonym


def _step(now: LiveSnapshot) -> str:
    """What comes next, said to the patient."""
    if now.stop_source:
        return _(_STOPPED)
    if now.state == "rehearsing":
        return _(_READY)
    if now.state != "playing":
        return _(_WAITING)
    return _(_HELD) if now.paused else _(_STEPS.get(now.phase, _GOING))


def _count(now: LiveSnapshot) -> str:
    if now.state != "playing" or now.repetitions < 1 or now.repetition < 0:
        return ""
    return _("%(n)s of %(m)s") % {"n": now.repetition + 1, "m": now.repetitions}


def _given_name(visit: Visit, pseudonym: str) -> str:
    """The given name only: the room reads this screen too."""
    try:
        return visit.site.patients.get(pseudonym).given_name
    except Refused:
        return ""


def _exercise(visit: Visit, take_id: str) -> str:
    if not take_id:
        return ""
    try:
        return exercise(visit.site.clinic.takes.get(take_id).exercise)
    except Refused:
        return ""
