"""Where the session stands, as the live page's script reads it."""

from __future__ import annotations

import time
from typing import Any

from rehab_app.services.runner_steps import STEPS, Course
from rehab_app.web.language import _


def course_state(course: Course | None) -> dict[str, Any] | None:
    """The session that goes on in the words and units of the screen; None where there is none.

    Args:
        course: The session.
    """
    if course is None:
        return None
    now_ns = time.time_ns()
    place = [step.key for step in STEPS].index(course.step.key)
    return {
        "patient": course.patient,
        "version": course.version,
        "step": course.step.key,
        "number": place + 1,
        "words": _(course.step.words),
        "told": _(course.step.told),
        "starts": course.step.starts,
        "back": STEPS[place - 1].key if place else "",
        "next": STEPS[place + 1].key if place + 1 < len(STEPS) else "",
        "checked_in": course.check_in > 0,
        "spent_s": round(course.spent_s(course.step.key, now_ns)),
        "minutes": course.step.minutes,
        "total_s": round((now_ns - course.began_utc_ns) * 1e-9),
        "total_minutes": sum(step.minutes for step in STEPS),
        "steps": [
            {"key": step.key, "words": _(step.words), "state": course.state_of(step.key)} for step in STEPS
        ],
    }
