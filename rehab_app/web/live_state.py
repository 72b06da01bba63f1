"""The live desk's newest picture as the page's script reads it."""

from __future__ import annotations

from typing import Any

import numpy as np

from rehab_app.errors import Refused
from rehab_app.services.snapshot import BUSY, LiveSnapshot
from rehab_app.web.render import day
from rehab_app.web.site import Site
from rehab_app.web.words import PHASES, STATES


def live_state(site: Site, page: str) -> dict[str, Any]:
    """State of the live desk in the words and units of the screen.

    Args:
        site: The site.
        page: The page that asks; it learns whether it is the operator's.
    """
    now = site.clinic.live.snapshot()
    return {
        "state": now.state,
        "word": "Held" if now.paused else STATES[now.state],
        "message": now.message,
        "busy": now.state in BUSY,
        "stopped": bool(now.stop_source),
        "paused": now.paused,
        "frame": now.frame,
        "t_s": round(now.t_s, 3),
        "patient": _patient(site, now),
        "side": now.side,
        "take": now.take_id,
        "session": now.session_id,
        "phase": PHASES.get(now.phase, now.phase.capitalize()),
        "repetition": now.repetition + 1,
        "repetitions": now.repetitions,
        "speed_percent": round(100.0 * now.speed),
        "tracking_percent": None if now.tracking_quality is None else round(100.0 * now.tracking_quality),
        "estimated_percent": round(100.0 * now.estimated_share),
        "lost_percent": round(100.0 * now.lost_share),
        "dropped": now.dropped,
        "countdown_s": now.countdown_s,
        "error_mm": _error_mm(now),
        "operator": site.operator.is_(page),
    }


def _error_mm(now: LiveSnapshot) -> float | None:
    if now.fingertip_error_m is None:
        return None
    return round(float(1e3 * np.sqrt(np.mean(np.square(now.fingertip_error_m)))), 2)


def _patient(site: Site, now: LiveSnapshot) -> dict[str, str] | None:
    """Name, birth date and side: the two identifiers and the hand that the screen must show."""
    if not now.patient_id:
        return None
    try:
        known = site.patients.get(now.patient_id)
    except Refused:
        return None
    return {
        "id": known.id,
        "name": f"{known.given_name} {known.family_name}".strip() or known.id,
        "born": day(known.birth_date),
        "side": known.side,
    }
