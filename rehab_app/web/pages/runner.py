"""The session runner on the live page: begin, step, check in, start, note, end."""

from __future__ import annotations

import math
from typing import Any

from starlette.responses import JSONResponse, Response

from rehab_app.services.journal import CheckIn
from rehab_app.services.order import EXOSKELETON, Order
from rehab_app.services.runner_plan import Choice
from rehab_app.web.language import _, written
from rehab_app.web.pages.asked import choice, number, whole
from rehab_app.web.visit import Visit, wants_json
from rehab_app.web.words import MODES, ROBOTS


def begin(visit: Visit) -> Response:
    """Begin a session with the patient whom somebody confirmed."""
    visit.site.clinic.runner.begin(visit.account, visit.asked("whom"), visit.asked("present"))
    return visit.go("/live", _("The session begins with the check-in."))


def step(visit: Visit) -> Response:
    """Go to another step."""
    runner = visit.site.clinic.runner
    runner.go(visit.account, visit.asked("at"), visit.asked("to"), visit.asked("reason"))
    return visit.go("/live")


def check_in(visit: Visit) -> Response:
    """Write the check-in and go on."""
    answers = CheckIn(
        pain=_score(visit, "pain"),
        skin=visit.asked("skin"),
        swelling=visit.asked("swelling"),
        botulinum_date=visit.asked("botulinum"),
        precautions=visit.asked("precautions"),
    )
    visit.site.clinic.runner.check_in(visit.account, answers)
    return visit.go("/live", _("The check-in is kept."))


def start(visit: Visit) -> Response:
    """Start what the step starts; this page operates from now on."""
    like = Order(
        device=choice(visit.asked("device") or EXOSKELETON, "robot", ROBOTS),
        twin=visit.asked("twin"),
        wrist_rad=math.radians(number(visit, "wrist", "wrist angle", "a number of degrees", 0.0)),
        realtime=True,
    )
    visit.site.clinic.runner.start(visit.account, visit.asked("at"), visit.asked("choice"), like)
    visit.site.operator.take_over(visit.asked("page"), visit.account.name)
    return visit.go("/live", _("Rehearsing on the virtual twin."))


def choices(visit: Visit) -> Response:
    """What the step that is shown can play."""
    return JSONResponse([_told(one) for one in visit.site.clinic.runner.choices()])


def note(visit: Visit) -> Response:
    """The note of the session so far."""
    told = visit.site.clinic.runner.note()
    return JSONResponse({"heading": told.heading, "text": told.text})


def end(visit: Visit) -> Response:
    """End the session; what is in the field becomes its note."""
    text = visit.form.get("note", "")
    patient = visit.site.clinic.runner.end(visit.account, text)
    said = (
        _("The session has ended, its note is in the journal.")
        if text.strip()
        else _("The session has ended.")
    )
    return visit.go_and_say(f"/patients/{patient}", said)


def pain(visit: Visit) -> Response:
    """Pain, by one tap: held and written; a second call says how much and where."""
    desk = visit.site.clinic.live
    held = desk.snapshot().state == "playing"
    entry = visit.site.clinic.runner.pain(
        visit.account, _score(visit, "score"), visit.asked("place"), whole(visit, "entry", "entry", 0)
    )
    said = _("Pain is noted, the movement is held.") if held else _("Pain is noted.")
    if not wants_json(visit.request):  # a patient's screen whose scripts are off
        return visit.go("/live" if visit.account.may("view") else "/mine", said)
    return JSONResponse({"message": said, "path": "/live", "entry": entry})


def operate(visit: Visit) -> Response:
    """This page operates from now on: its silence holds the movement."""
    visit.site.operator.take_over(visit.asked("page"), visit.account.name)
    return visit.go("/live", _("This page operates now."))


def _score(visit: Visit, name: str) -> int | None:
    return whole(visit, name, "pain") if visit.asked(name) else None


def _told(one: Choice) -> dict[str, Any]:
    item = one.item
    dose = _("%(mode)s, %(count)s repetitions, %(minutes)s min, hold %(hold)s s") % {
        "mode": _(MODES.get(item.mode, item.mode)),
        "count": item.repetitions,
        "minutes": written(item.minutes),
        "hold": written(item.hold_s),
    }
    return {
        "key": one.key,
        "words": _(one.words),
        "dose": dose,
        "remark": item.remark,
        "ready": bool(one.take) and not one.locked,
        "why": one.locked or ("" if one.take else _("No approved take yet.")),
        "prescribed": one.prescribed,
    }
