"""The live page: what it shows, recording, the target grip, pain. Runs are in ``live_run``."""

from __future__ import annotations

from starlette.responses import JSONResponse, Response

from rehab_app.errors import Refused
from rehab_app.services.grip_target import choice_fields, grip_choice
from rehab_app.services.journal_records import SKIN, SWELLING
from rehab_app.services.recording_request import LIVE_KINDS, PROTOCOL, VIRTUAL
from rehab_app.web.language import _
from rehab_app.web.live_state import live_state
from rehab_app.web.pages.asked import number
from rehab_app.web.pages.choices import patient_choices, take_choices
from rehab_app.web.pages.first_steps import first_steps
from rehab_app.web.visit import Visit
from rehab_app.web.words import MODES, ROBOTS, SPACES, TWINS
from rehab_app.web.words_cameras import STATES, camera_label, camera_remedy

_MILLIMETRES = "a number of millimetres"
_SECONDS = ("recording length", "a number of seconds")


def live(visit: Visit) -> Response:
    """The page itself: shell panel, viewport, state bar."""
    clinic, asked = visit.site.clinic, visit.request.query_params
    chosen_patient = asked.get("patient", "")
    chosen_take = asked.get("take", "")
    return visit.page(
        "live.html.j2",
        exercises=clinic.takes.exercises(),
        protocols=clinic.takes.protocols(),
        takes=take_choices(visit, kept=chosen_take),
        patients=patient_choices(visit, kept=chosen_patient),
        modes=MODES,
        twins=TWINS,
        robots=ROBOTS,
        spaces=SPACES,
        chosen_patient=chosen_patient,
        chosen_take=chosen_take,
        chosen_exercise=asked.get("exercise", "") or "open_close",
        skin=SKIN,
        swelling=SWELLING,
        first=first_steps(visit),
        aim=choice_fields(clinic.live.target.choice),
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


def record(visit: Visit) -> Response:
    """Count down and record."""
    visit.site.clinic.live.start_recording(
        visit.account,
        visit.asked("exercise"),
        visit.asked("side"),
        number(visit, "seconds", *_SECONDS),
        countdown_s=number(visit, "countdown", "countdown", "a number of seconds"),
        camera=_camera(visit),
        protocol=_protocol(visit),
        person=visit.asked("person"),
        consent_images=visit.asked("consent") == "yes",
    )
    visit.site.operator.take_over(visit.asked("page"), visit.account.name)
    return visit.go("/live", _("Recording starts after the countdown."))


def cameras(visit: Visit) -> Response:
    """Cameras that can be recorded from, for the list of the page."""
    return JSONResponse(
        [
            {
                "id": one.id,
                "words": camera_label(one.label),
                "ready": one.state == "ready",
                "state": one.state,
                "state_words": _(STATES[one.state]),
                "has_depth": one.has_depth,
                "remedy": camera_remedy(one.remedy),
            }
            for one in visit.site.clinic.takes.cameras()
        ]
    )


def finish(visit: Visit) -> Response:
    """End the recording and keep what there is."""
    visit.site.clinic.live.finish_recording(visit.account)
    return visit.go("/live", _("The recording was ended."))


def target(visit: Visit) -> Response:
    """Show a target grip beside the hands, or none; it moves nothing and may change at any time."""
    kind = visit.asked("object")
    size_mm = 0.0 if kind == "none" else number(visit, "size", "size of the object", _MILLIMETRES)
    width_mm = number(visit, "width", "width of the object", _MILLIMETRES) if kind == "box" else 0.0
    choice = grip_choice(kind, size_mm, visit.asked("grip") or "transverse", width_mm)
    visit.site.clinic.live.target.choose(visit.account, choice)
    said = _("Target: %(words)s.") % {"words": "" if choice is None else choice.words}
    return visit.go("/live", _("No target grip.") if choice is None else said)


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
