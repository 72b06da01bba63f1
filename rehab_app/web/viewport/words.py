"""What the live panel says in words for each state of the desk."""

from __future__ import annotations

from rehab_app.services.snapshot import LiveSnapshot
from rehab_app.web.viewport.verdict import Verdict, of_error

FULL_SUPPORT_MULTIPLE = 4.0
"""Stiffness multiple that counts as 100 % support: the most that assist-as-needed may give."""
PHASES = {
    "approach": "Moving to the start",
    "ramp": "Taking hold gently",
    "cue": "Your turn: start the movement",
    "move": "Moving",
    "hold": "Holding",
    "return": "Moving back",
    "rest": "Rest",
    "stopped": "Stopped",
    "done": "Finished",
    "open": "Open your hand",
    "tabletop": "Bend the knuckles, fingers straight",
    "hook": "Bend the fingers, knuckles straight",
    "fist": "Make a fist",
    "check": "Let the hand rest: joint by joint",
    "fold": "Bending gently to the start",
    "stretch": "Let the hand be stretched",
    "rest-proposed": "Rest for a minute",
    "skin-check": "Time to look at the skin",
}
_ALONE = "On your own, as far as you can."
_LED = "The robot leads on gently: let it."
_STARTERS = {"patient": "patient", "robot": "robot helped"}


def verdict_of(snapshot: LiveSnapshot) -> Verdict:
    """The card for a snapshot."""
    if snapshot.state == "playing" and snapshot.fingertip_error_m is not None:
        return of_error(snapshot.fingertip_error_m)
    if snapshot.state == "recording":
        quality = snapshot.tracking_quality
        if quality is None:
            return Verdict(
                "calm", "Recording", detail="Looking for the markers: keep the hand open and still."
            )
        style = "good" if quality >= 0.8 else "caution"
        word = "Recording, hand well seen" if quality >= 0.8 else "Recording, some markers hidden"
        return Verdict(style, word, f"{100 * quality:.0f}", "% of markers seen", snapshot.message)
    if snapshot.state == "countdown":
        return Verdict("calm", "Get ready", f"{max(snapshot.countdown_s, 0.0):.0f}", "s", snapshot.message)
    style, word = {
        "idle": ("calm", "Ready"),
        "processing": ("calm", "Saving the take"),
        "rehearsing": ("calm", "Rehearsing: nothing moves yet"),
        "playing": ("calm", PHASES.get(snapshot.phase, snapshot.phase) or "Starting"),
        "stopped": ("alarm", "STOPPED"),
        "done": ("good", "Done"),
        "failed": ("caution", "Not done"),
    }[snapshot.state]
    return Verdict(style, word, detail=_whose_turn(snapshot) or snapshot.message)


def _whose_turn(snapshot: LiveSnapshot) -> str:
    """In a posture of the range sweep, who moves."""
    if snapshot.kind != "range" or snapshot.state != "playing" or snapshot.paused or snapshot.phase == "rest":
        return ""
    return {"patient": _ALONE, "robot": _LED}.get(snapshot.started_by, "")


def facts_of(snapshot: LiveSnapshot) -> tuple[tuple[str, str], ...]:
    """The lines beneath the card."""
    if snapshot.state not in ("playing", "stopped", "done") or not snapshot.kind:
        return ()
    rows = [("Phase", "Paused" if snapshot.paused else PHASES.get(snapshot.phase, snapshot.phase or "-"))]
    if snapshot.repetitions:
        done = min(max(snapshot.repetition + 1, 0), snapshot.repetitions)
        counted = "Posture" if snapshot.kind == "range" else "Repetition"
        rows.append((counted, f"{done} of {snapshot.repetitions}"))
    if snapshot.started_by and snapshot.kind == "therapy":
        rows.append(("Started by", _STARTERS.get(snapshot.started_by, snapshot.started_by)))
    if snapshot.support is not None:
        share = min(snapshot.support / FULL_SUPPORT_MULTIPLE, 1.0)
        rows.append(("Support", f"{100 * share:.0f} % (×{snapshot.support:.1f})"))
    if snapshot.interaction_nm is not None:
        rows.append(("Torque on the hand", f"{snapshot.interaction_nm:.2f} Nm"))
    if not snapshot.worn:
        rows.append(("Robot", "worn by nobody"))
    rows.append(("Loop lateness", _lateness(snapshot)))
    return tuple(rows)


def _lateness(snapshot: LiveSnapshot) -> str:
    return f"p99 {1e-6 * snapshot.late_p99_ns:.1f} ms, {snapshot.overruns} missed"
