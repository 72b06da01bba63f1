"""Help inside: first steps, what each page is for, keys, and the words with their units."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.web.language import marked
from rehab_app.web.pages.first_steps import STEPS
from rehab_app.web.visit import Visit

_PAGES = (
    ("live", marked("Live"), marked("Records a take, plays it on the robot, and leads through a session.")),
    (
        "patients",
        marked("Patients"),
        marked("Who is treated: diagnosis and locks, limits, plan, progress, outcomes, journal, data."),
    ),
    (
        "exercises",
        marked("Exercises"),
        marked("The library: choose by picture or purpose, prescribe it or record a take of it."),
    ),
    ("takes", marked("Takes"), marked("Recorded movements: look, trim, smooth, slow, scale, approve.")),
    (
        "sessions",
        marked("Sessions"),
        marked("What the patient's hand did: replay, report, comparison of two sessions."),
    ),
    ("clinic", marked("Clinic"), marked("Your password, users, audit, devices, calibration and backup.")),
)
_KEYS = (
    ("Esc", marked("Stops the robot on every page. It does not replace the hardware stop.")),
    ("Tab", marked("To the next field or button; the first press offers to skip to the page.")),
    ("← →", marked("Between the tabs of the live page; from marker to marker when naming them.")),
    ("Enter", marked("Presses the chosen button; names the chosen marker.")),
    ("Ctrl Z", marked("Takes back the last marker name.")),
)
_WORDS = (
    (marked("Take"), "s", marked("A recorded movement that the robot can follow once it is approved.")),
    (
        marked("Session"),
        "min",
        marked("What was done with a patient on one occasion, from check-in to note."),
    ),
    (marked("Reference"), "", marked("The movement of the take, fitted to the patient's hand.")),
    (marked("Range"), "°", marked("From the least to the greatest angle of a joint, alone or led.")),
    (
        marked("Torque"),
        "Nm",
        marked("How strongly the robot turns a joint; the limits of the day bound it."),
    ),
    (marked("Support"), "%", marked("How much the robot helps: 0 nothing, 100 the most that it may give.")),
    (marked("Tracking error"), "mm", marked("How far the fingertips are from the reference.")),
    (marked("Speed"), "%", marked("Of the speed at which the movement was recorded.")),
    (marked("Impedance"), "", marked("How softly the robot holds to the reference: stiffness and damping.")),
    (
        marked("Latched stop"),
        "",
        marked("After a stop nothing moves until a therapist has looked and clears it."),
    ),
)


def guide(visit: Visit) -> Response:
    """The page."""
    return visit.page("help.html.j2", steps=STEPS, parts=_PAGES, keys=_KEYS, words=_WORDS)
