"""What the live panel says in words for each state of the desk."""

from __future__ import annotations

from rehab_app.services.snapshot import LiveSnapshot
from rehab_app.web.language import _, marked, written
from rehab_app.web.viewport.verdict import Verdict, of_error

FULL_SUPPORT_MULTIPLE = 4.0
"""Stiffness multiple that counts as 100 % support: the most that assist-as-needed may give."""
PHASES = {
    "approach": marked("Moving to the start"),
    "ramp": marked("Taking hold gently"),
    "cue": marked("Your turn: start the movement"),
    "move": marked("Moving"),
    "hold": marked("Holding"),
    "return": marked("Moving back"),
    "rest": marked("Rest"),
    "stopped": marked("Stopped"),
    "done": marked("Finished"),
    "open": marked("Open your hand"),
    "tabletop": marked("Bend the knuckles, fingers straight"),
    "hook": marked("Bend the fingers, knuckles straight"),
    "fist": marked("Make a fist"),
    "check": marked("Let the hand rest: joint by joint"),
    "fold": marked("Bending gently to the start"),
    "stretch": marked("Let the hand be stretched"),
    "rest-proposed": marked("Rest for a minute"),
    "skin-check": marked("Time to look at the skin"),
}
_ALONE = marked("On your own, as far as you can.")
_LED = marked("The robot leads on gently: let it.")
_STARTERS = {"patient": marked("patient"), "robot": marked("robot helped")}
_STATES = {
    "idle": ("calm", marked("Ready")),
    "processing": ("calm", marked("Saving the take")),
    "rehearsing": ("calm", marked("Rehearsing: nothing moves yet")),
    "stopped": ("alarm", marked("STOPPED")),
    "done": ("good", marked("Done")),
    "failed": ("caution", marked("Not done")),
}
_COUNTED = {"range": marked("Posture"), "tone": marked("Stretch")}


def verdict_of(snapshot: LiveSnapshot) -> Verdict:
    """The card for a snapshot."""
    if snapshot.state == "playing" and snapshot.fingertip_error_m is not None:
        return of_error(snapshot.fingertip_error_m)
    if snapshot.state == "recording":
        quality = snapshot.tracking_quality
        if quality is None:
            detail = _("Looking for the markers: keep the hand open and still.")
            return Verdict("calm", _("Recording"), detail=detail)
        style = "good" if quality >= 0.8 else "caution"
        seen = marked("Recording, hand well seen")
        word = seen if quality >= 0.8 else marked("Recording, some markers hidden")
        share, message = f"{100 * quality:.0f}", _(snapshot.message)
        return Verdict(style, _(word), share, _("% of markers seen"), message)
    if snapshot.state == "countdown":
        left = f"{max(snapshot.countdown_s, 0.0):.0f}"
        return Verdict("calm", _("Get ready"), left, "s", _(snapshot.message))
    playing = ("calm", PHASES.get(snapshot.phase, snapshot.phase) or marked("Starting"))
    style, word = playing if snapshot.state == "playing" else _STATES[snapshot.state]
    return Verdict(style, _(word), detail=_(_whose_turn(snapshot) or snapshot.message))


def _whose_turn(snapshot: LiveSnapshot) -> str:
    """In a posture of the range sweep, who moves."""
    if snapshot.kind != "range" or snapshot.state != "playing" or snapshot.paused or snapshot.phase == "rest":
        return ""
    return {"patient": _ALONE, "robot": _LED}.get(snapshot.started_by, "")


def facts_of(snapshot: LiveSnapshot) -> tuple[tuple[str, str], ...]:
    """The lines beneath the card."""
    if snapshot.state not in ("playing", "stopped", "done") or not snapshot.kind:
        return ()
    phase = marked("Paused") if snapshot.paused else PHASES.get(snapshot.phase, snapshot.phase or "-")
    rows = [(_("Phase"), _(phase))]
    if snapshot.repetitions:
        done = min(max(snapshot.repetition + 1, 0), snapshot.repetitions)
        counted = _(_COUNTED.get(snapshot.kind, marked("Repetition")))
        rows.append((counted, _("%(n)s of %(m)s") % {"n": done, "m": snapshot.repetitions}))
    if snapshot.started_by and snapshot.kind == "therapy":
        rows.append((_("Started by"), _(_STARTERS.get(snapshot.started_by, snapshot.started_by))))
    if snapshot.support is not None:
        share = min(snapshot.support / FULL_SUPPORT_MULTIPLE, 1.0)
        rows.append((_("Support"), f"{100 * share:.0f} % (×{written(snapshot.support, 1)})"))
    if snapshot.interaction_nm is not None:
        rows.append((_("Torque on the hand"), f"{written(snapshot.interaction_nm, 2)} Nm"))
    if not snapshot.worn:
        rows.append((_("Robot"), _("worn by nobody")))
    rows.append((_("Loop lateness"), _lateness(snapshot)))
    return tuple(rows)


def _lateness(snapshot: LiveSnapshot) -> str:
    late = {"late": written(1e-6 * snapshot.late_p99_ns, 1), "missed": snapshot.overruns}
    return _("p99 %(late)s ms, %(missed)s missed") % late
