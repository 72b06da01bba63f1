"""The live desk's newest picture as the page's script reads it."""

from __future__ import annotations

import secrets
from typing import Any

import numpy as np

from rehab_app.errors import Refused
from rehab_app.services.live_interrupted import Restored
from rehab_app.services.live_target import way_of
from rehab_app.services.snapshot import ALONG, BUSY, LiveSnapshot
from rehab_app.web.language import _
from rehab_app.web.render import day, moment
from rehab_app.web.runner_state import course_state
from rehab_app.web.site import Site
from rehab_app.web.words import ASKED, ASSESSED, FOLLOW, MODES, NEXT, PHASES, ROBOTS, RUNS, STATES, TOLD

_SERVER = secrets.token_hex(4)
"""Names this process: a page that sees another name has outlived a restart and asks for its picture anew."""


def live_state(site: Site, page: str) -> dict[str, Any]:
    """State of the live desk in the words and units of the screen.

    Args:
        site: The site.
        page: The page that asks; it learns whether it is the operator's.
    """
    now = site.clinic.live.snapshot()
    return {
        "state": now.state,
        "word": _word(now),
        "message": _message(now),
        "busy": now.state in BUSY,
        "stopped": bool(now.stop_source),
        "paused": now.paused,
        "reversing": now.reversing,
        "kind": now.kind,
        "acts": acts_of(now),
        "run": _run(now),
        "notes": now.notes,
        "frame": now.frame,
        "t_s": round(now.t_s, 3),
        "patient": _patient(site, now),
        "side": now.side,
        "take": now.take_id,
        "session": now.session_id,
        "phase": _phase(now),
        "repetition": now.repetition + 1,
        "repetitions": now.repetitions,
        "speed_percent": round(100.0 * now.speed),
        "tracking_percent": None if now.tracking_quality is None else round(100.0 * now.tracking_quality),
        "estimated_percent": round(100.0 * now.estimated_share),
        "lost_percent": round(100.0 * now.lost_share),
        "dropped": now.dropped,
        "countdown_s": now.countdown_s,
        "error_mm": _error_mm(now),
        "target": _target(now),
        "operator": site.operator.is_(page),
        "operator_words": _("This page") if site.operator.is_(page) else site.operator.name or _("Nobody"),
        "session_course": _course(site),
        "server": _SERVER,
        "interrupted": [_restored(one) for one in site.clinic.interrupted.found],
    }


def _restored(one: Restored) -> dict[str, str]:
    """A recording that an ended server left unsealed, in words, and where it is."""
    if one.trouble:
        return {"words": one.trouble, "path": ""}
    words = _("The take of %(when)s was interrupted and is restored.")
    if one.kind == "sessions":
        words = _("The session of %(when)s was interrupted and is restored.")
    return {"words": words % {"when": moment(one.began_utc_ns)}, "path": f"/{one.kind}/{one.id}"}


def _course(site: Site) -> dict[str, Any] | None:
    """Where the session stands, and whom it is with."""
    course = site.clinic.runner.course
    told = course_state(course)
    if course is None or told is None:
        return None
    return told | {"who": _identity(site, course.patient), "done": site.clinic.runner.done()}


def _message(now: LiveSnapshot) -> str:
    """What is asked of the therapist now; held, why."""
    if now.paused or now.state != "playing":
        return _(now.message)
    if now.kind == "tracking":
        return _(FOLLOW)
    told = TOLD if now.kind == "tone" else ASKED
    return _(told.get(now.phase, now.message))


def _word(now: LiveSnapshot) -> str:
    if now.paused:
        return _("Held")
    if now.state != "playing":
        return _(STATES[now.state])
    return _("Going back") if now.reversing else _(RUNS.get(now.kind, STATES["playing"]))


def _phase(now: LiveSnapshot) -> str:
    """The phase in words; in a posture of the sweep, whose turn it is."""
    words = _(PHASES.get(now.phase, now.phase.capitalize()))
    if now.kind == "range" and now.started_by and now.phase != "rest":
        return words + ": " + (_("alone") if now.started_by == "patient" else _("led on"))
    return words


def acts_of(now: LiveSnapshot) -> dict[str, str]:
    """Buttons of the run that goes on, by verb, in words; what is not here cannot be asked for now."""
    if now.state != "playing":
        return {}
    if now.phase == "skin-check" and not now.paused:
        return {"resume": "✓ " + _("Skin looked at: go on")}
    if now.paused:
        return {"resume": "▶ " + _("Resume")}
    if now.reversing:
        return {"pause": "❚❚ " + _("Pause"), "resume": "▶ " + _("Resume forwards")}
    acts = {"pause": "❚❚ " + _("Pause")}
    if now.kind == "range":
        acts |= {"reverse": "◀ " + _("Back to rest"), "next": "» " + _next_posture(now)}
    elif now.kind == "tone":
        acts["reverse"] = "◀ " + _("End the test here")
    elif now.kind in ALONG:
        acts["reverse"] = "◀ " + _("Reverse")
        if now.phase in NEXT:
            acts["next"] = "» " + _(NEXT[now.phase])
    return acts


def _next_posture(now: LiveSnapshot) -> str:
    if now.phase == "rest":
        return _("Next posture")
    return _("Lead on") if now.started_by == "patient" else _("Next")


def _run(now: LiveSnapshot) -> str:
    """What is run, on what: Active-assisted, exoskeleton (simulation)."""
    if not now.kind:
        return ""
    run = ASSESSED.get(now.kind) or MODES.get(now.mode, now.mode)
    return f"{_(run)}, {_(ROBOTS.get(now.device, now.device))}"


def _target(now: LiveSnapshot) -> dict[str, Any]:
    """The target grip, how far the hand is from it, and why there is none."""
    found, way = now.grip, way_of(now)
    return {
        "words": found.words,
        "refused": found.refused,
        "ready": found.target is not None,
        "to_go_mm": None if way is None else round(1e3 * way.farthest_m),
        "farthest": "" if way is None else way.farthest,
    }


def _error_mm(now: LiveSnapshot) -> float | None:
    if now.fingertip_error_m is None:
        return None
    return round(float(1e3 * np.sqrt(np.mean(np.square(now.fingertip_error_m)))), 2)


def _patient(site: Site, now: LiveSnapshot) -> dict[str, str] | None:
    """Name, birth date and side: the two identifiers and the hand that the screen must show."""
    return _identity(site, now.patient_id)


def _identity(site: Site, patient: str) -> dict[str, str] | None:
    if not patient:
        return None
    try:
        known = site.patients.get(patient)
    except Refused:
        return None
    return {
        "id": known.id,
        "name": f"{known.given_name} {known.family_name}".strip() or known.id,
        "born": day(known.birth_date),
        "side": known.side,
    }
