"""Runs on the live page: therapy, assessments, the fit; and what is asked of them while they go on."""

from __future__ import annotations

import math
from typing import Any

from starlette.responses import JSONResponse, Response

from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.order import EXOSKELETON, Order
from rehab_app.web.language import _
from rehab_app.web.pages.asked import choice, decimal, number, whole
from rehab_app.web.pages.recordings import catalogue_id
from rehab_app.web.render import clock
from rehab_app.web.visit import Visit
from rehab_app.web.words import ROBOTS
from robot_iface.build import capabilities

_PERCENT = "a number of percent"


def play(visit: Visit) -> Response:
    """Rehearse, then play. Takes are named by catalogue id only."""
    patient = _patient(visit)
    visit.site.clinic.live.start_therapy(
        visit.account, patient, _take(visit), _order(visit), present=_present(visit, patient)
    )
    visit.site.operator.take_over(visit.asked("page"), visit.account.name)
    return visit.go("/live", _("Rehearsing on the virtual twin."))


def measure(visit: Visit) -> Response:
    """Measure today's range in the guided sweep."""
    return _assess(visit, "range")


def fit(visit: Visit) -> Response:
    """Check fit and signs after donning."""
    return _assess(visit, "fit")


def tone(visit: Visit) -> Response:
    """Measure the resistance to stretches at three speeds."""
    return _assess(visit, "tone", arm_posture=visit.asked("arm"))


def tracking(visit: Visit) -> Response:
    """Let the patient follow the chosen take alone."""
    return _assess(visit, "tracking", take_id=_take(visit))


def pause(visit: Visit) -> Response:
    """Hold the path."""
    visit.site.clinic.live.controls.pause(visit.account)
    return visit.go("/live", _("Paused."))


def resume(visit: Visit) -> Response:
    """Go on; the page that resumes is the operator's from now on."""
    visit.site.operator.take_over(visit.asked("page"), visit.account.name)
    visit.site.clinic.live.controls.resume(visit.account)
    return visit.go("/live", _("Going on."))


def reverse(visit: Visit) -> Response:
    """Go back along the path."""
    visit.site.clinic.live.controls.reverse(visit.account)
    return visit.go("/live", _("Going back."))


def advance(visit: Visit) -> Response:
    """What comes next: the next repetition or posture, or the robot's help."""
    visit.site.clinic.live.controls.advance(visit.account)
    return visit.go("/live", _("Next."))


def speed(visit: Visit) -> Response:
    """Another path speed, in percent of the therapist's."""
    asked = number(visit, "speed", "speed", _PERCENT)
    visit.site.clinic.live.controls.set_speed(visit.account, asked / 100.0)
    return visit.go("/live", _("Speed %(n)s %%.") % {"n": f"{asked:.0f}"})


def limits(visit: Visit) -> Response:
    """Where a patient's limits come from today, and which modes are locked."""
    asked = visit.request.query_params
    device = choice(asked.get("device", EXOSKELETON), "robot", ROBOTS)
    patient = asked.get("patient", "")
    # refused below where it is none, as every angle that is none
    wrist_rad = math.radians(decimal(asked.get("wrist", "") or "0"))
    try:
        told = _limits(visit, patient, device, wrist_rad)
    except REFUSALS as refusal:
        words = f"{refusal.thing} is {refusal.value}, but must be {refusal.bound}."
        told = {"kind": "caution", "words": words[:1].upper() + words[1:], "more": (), "locked": {}}
    return JSONResponse({"patient": patient, "worn": capabilities(device).worn, **told})


def _limits(visit: Visit, patient: str, device: str, wrist_rad: float) -> dict[str, Any]:
    clinic = visit.site.clinic
    if not capabilities(device).worn:
        words = _("Nobody wears this robot: its own range and speed hold.")
        return {"kind": "", "words": words, "more": (), "locked": {}}
    if not patient:
        return {"kind": "", "words": _("Shipped defaults, for an average hand."), "more": (), "locked": {}}
    locked: dict[str, str] = dict(clinic.clinical.locks(patient))
    today = clinic.limits.show(patient, device, wrist_rad)
    held = today.limits
    if today.measured:
        measured = {"time": clock(held.measured_utc_ns), "n": f"{math.degrees(held.wrist_rad):.0f}"}
        words = _("Measured today %(time)s, wrist %(n)s°.") % measured
    else:
        words = _("Shipped defaults: not measured today.")
    return {
        "kind": "good" if today.measured else "caution",
        "words": words,
        "more": today.notes[1:],
        "locked": locked,
    }


def _assess(visit: Visit, kind: str, *, take_id: str = "", arm_posture: str = "") -> Response:
    patient = _patient(visit)
    visit.site.clinic.live.start_assessment(
        visit.account,
        kind,
        patient,
        _order(visit),
        present=_present(visit, patient),
        take_id=take_id,
        arm_posture=arm_posture,
    )
    visit.site.operator.take_over(visit.asked("page"), visit.account.name)
    return visit.go("/live", _("Rehearsing on the virtual twin."))


def _patient(visit: Visit) -> str | None:
    return visit.asked("patient") or None


def _present(visit: Visit, patient: str | None) -> str | None:
    """Who sits at the robot, as a person confirmed by name, birth date and side (hazard 1).

    Raises:
        Refused: A patient was chosen and nobody confirmed that it is this one.
    """
    if patient is None:
        return None
    visit.site.clinic.patients.get(patient)
    present = visit.asked("present")
    if not present:
        raise Refused(
            "patient",
            "not confirmed",
            "confirmed by name, birth date and side",
            "compare them with the patient and tick the box",
        )
    return present


def _order(visit: Visit) -> Order:
    """What the form asks for; what it leaves out is as shipped.

    Raises:
        Refused: A field holds no number or no choice, or is out of bounds.
    """
    stiffness, hold = visit.asked("stiffness"), visit.asked("hold")
    return Order(
        device=choice(visit.asked("device") or EXOSKELETON, "robot", ROBOTS),
        mode=visit.asked("mode") or "passive",
        speed=number(visit, "speed", "speed", _PERCENT, 50.0) / 100.0,
        repetitions=whole(visit, "repetitions", "repetitions", 3),
        twin=visit.asked("twin"),
        stiffness_multiple=number(visit, "stiffness", "stiffness", "a number of times")
        if stiffness
        else None,
        realtime=True,
        space=visit.asked("space") or "joint",
        warm_up=whole(visit, "warm_up", "warm-up repetitions", 0),
        minutes=number(visit, "minutes", "minutes", "a number of minutes", 0.0),
        resistance=number(visit, "resistance", "resistance", _PERCENT, 30.0) / 100.0,
        hold_s=number(visit, "hold", "hold", "a number of seconds") if hold else None,
        wrist_rad=math.radians(number(visit, "wrist", "wrist angle", "a number of degrees", 0.0)),
    )


def _take(visit: Visit) -> str:
    named = visit.asked("take")
    if not named:
        raise Refused("take", "not chosen", "an approved take", "choose one, or record and approve one first")
    return catalogue_id(named)
