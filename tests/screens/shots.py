"""Every picture of ``make screens``: which page, in which state, and what it shows."""

from __future__ import annotations

from dataclasses import dataclass

DESKTOP, TABLET = (1440, 900), (1024, 768)


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture.

    Attributes:
        name: Of its file, without the end.
        route: The route as the table of routes names it, empty for another state of a page that has one.
        path: What the browser asks for, with names of ``Seeded`` in braces.
        words: One line of what it shows.
        tablet: Whether it is taken at tablet size too.
        state: What is done to the page first; empty for nothing.
    """

    name: str
    route: str
    path: str
    words: str
    tablet: bool = False
    state: str = ""


def _one(
    name: str, route: str, words: str, *, tablet: bool = False, asked: str = "", state: str = ""
) -> Shot:
    """A picture of a route; ``asked`` follows its path."""
    path = route.removeprefix("GET ").replace("{recording}", "{take}" if "/takes" in route else "{session}")
    return Shot(name, route, path + asked, words, tablet, state)


SIGNED_OUT = (_one("sign-in", "GET /sign-in", "Signing in; the stop works before it.", tablet=True),)
SHOTS = (
    _one(
        "live",
        "GET /live",
        "The live page, nothing going on: therapy, patient chosen.",
        tablet=True,
        state="chosen",
    ),
    Shot("live-session", "", "/live", "Live: the session that the page leads through.", True, "session"),
    Shot("live-record", "", "/live", "Live: recording a take.", False, "record"),
    _one("patients", "GET /patients", "Patients: search, sort, add.", tablet=True),
    _one("patient-new", "GET /patients/new", "A new patient."),
    _one("patient", "GET /patients/{patient}", "One patient: what a therapist must know first.", tablet=True),
    _one("patient-edit", "GET /patients/{patient}/edit", "Correcting a patient's record."),
    _one("patient-diagnosis", "GET /patients/{patient}/diagnosis", "Diagnosis, its locks and precautions."),
    _one("patient-limits", "GET /patients/{patient}/limits", "Limits of the joints today, and who set them."),
    _one("patient-plan", "GET /patients/{patient}/plan", "The standing plan."),
    Shot(
        "patient-plan-item",
        "",
        "/patients/{patient}/plan?add=open_close#item",
        "The plan: an exercise is added.",
    ),
    _one("patient-progress", "GET /patients/{patient}/progress", "Progress over the sessions."),
    _one(
        "patient-compare",
        "GET /patients/{patient}/compare",
        "Two sessions beside each other.",
        asked="?first={earlier}&second={session}",
    ),
    _one("patient-next", "GET /patients/{patient}/next", "The proposed next step, and why."),
    _one("patient-assessments", "GET /patients/{patient}/assessments", "Assessments on the robot."),
    _one("patient-outcomes", "GET /patients/{patient}/outcomes", "Outcome measures that the clinic enters."),
    _one("patient-journal", "GET /patients/{patient}/journal", "Notes, pain, adverse events."),
    _one("patient-sessions", "GET /patients/{patient}/sessions", "The sessions of one patient."),
    _one("patient-data", "GET /patients/{patient}/data", "Consent, export, erasure."),
    _one("exercises", "GET /exercises", "The library of exercises."),
    Shot("exercise", "GET /exercises/{name:path}", "/exercises/open_close", "One exercise."),
    _one("takes", "GET /takes", "Takes with their approval."),
    _one("take", "GET /takes/{recording}", "One take: look at it, approve, retouch."),
    Shot(
        "take-compare",
        "GET /takes/{recording}/compare",
        "/takes/{retouched}/compare",
        "A retouched take beside its original.",
    ),
    _one("take-names", "GET /takes/{recording}/names", "Naming the markers of a take by hand."),
    _one("take-report", "GET /takes/{recording}/report", "Report of a take."),
    _one("sessions", "GET /sessions", "Played sessions."),
    _one("session", "GET /sessions/{recording}", "Review of a played session."),
    _one("session-report", "GET /sessions/{recording}/report", "Report of a session.", tablet=True),
    _one("account", "GET /account", "My own account and password."),
    _one("clinic", "GET /clinic", "What belongs to the clinic."),
    _one("clinic-users", "GET /clinic/users", "Who may sign in."),
    _one("clinic-settings", "GET /clinic/settings", "Name, language and rules of the clinic."),
    _one("clinic-stations", "GET /clinic/stations", "Therapy stations of this clinic."),
    _one("clinic-audit", "GET /clinic/audit", "The chained audit."),
    _one("clinic-devices", "GET /clinic/devices", "Cameras and robots."),
    _one("clinic-calibration", "GET /clinic/calibration", "Calibrating a camera."),
    _one("clinic-backup", "GET /clinic/backup", "Encrypted backup and restore.", state="backup"),
    _one("help", "GET /help", "Help."),
    Shot("refused", "", "/there-is-no-such-page", "A sentence where a page does not exist."),
    Shot("live-playing", "", "/live", "Live: therapy going on.", True, "playing"),
    Shot("live-stopped", "", "/live", "Live: stopped, until somebody has looked.", False, "stopped"),
)
FOR_THE_PATIENT = (_one("mine", "GET /mine", "The patient's own screen.", tablet=True),)
TOO_LATE = (_one("kept", "GET /kept", "What was typed when the sign-in had ended."),)
FIRST_RUN = (_one("set-up", "GET /set-up", "The first account of an empty clinic."),)
EVERY = (*FIRST_RUN, *SIGNED_OUT, *SHOTS, *FOR_THE_PATIENT, *TOO_LATE)

NO_PICTURE = {
    "GET /": "leads to the page that the role begins with",
    "GET /here": "answers a script",
    "GET /stop/state": "answers a script",
    "GET /healthz": "answers a monitor",
    "GET /healthz/live": "answers a monitor",
    "GET /metrics": "answers a monitor",
    "GET /prescribe": "leads to the plan of the patient who was chosen, as patient-plan-item",
    "GET /mine/state": "answers a script",
    "GET /live/takes": "answers a script",
    "GET /live/patients": "answers a script",
    "GET /live/cameras": "answers a script",
    "GET /live/limits": "answers a script",
    "GET /live/session/choices": "answers a script",
    "GET /live/session/note": "answers a script",
    "GET /live/view/": "the 3-D panel inside live",
    "GET /review/{recording}/view/": "the 3-D panel inside review",
    "GET /clinic/audit.csv": "a file to take away",
    "GET /clinic/backup/file/{name}": "a file to take away",
    "GET /clinic/calibration/board.{kind}": "a file to take away",
    "GET /patients/{patient}/progress.{format}": "a file to take away",
    "GET /patients/{patient}/compare.{format}": "a file to take away",
    "GET /exercise-pictures/{name}/{view}/{side}.svg": "a drawing inside exercise",
    "GET /takes/{recording}/joints/{which}.svg": "a chart inside take and take-compare",
    "GET /takes/{recording}/first.jpg": "an image inside take-names",
    "GET /takes/{recording}/report.html": "the report inside take-report",
    "GET /takes/{recording}/report.json": "a file to take away",
    "GET /takes/{recording}/report.{format}": "a file to take away",
    "GET /sessions/{recording}/report.html": "the report inside session-report",
    "GET /sessions/{recording}/report.json": "a file to take away",
    "GET /sessions/{recording}/report.{format}": "a file to take away",
}
"""Routes without a picture of their own, and why."""
