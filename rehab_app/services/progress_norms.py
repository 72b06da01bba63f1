"""The latest session beside the norms of the clinic, as the progress report prints them."""

from __future__ import annotations

from collections.abc import Sequence

from rehab_app.services.population import in_words
from rehab_app.services.population_norms import KEY, Norms
from sessions.catalogue import Catalogue, TherapySession
from sessions.metrics import definition
from sessions.reports.past import Past
from sessions.reports.progress import Beside

SHOWN = ("range_of_motion", "total_active_motion", "sparc", "movement_time")
"""Numbers that a norm says something about; an error or a dose is what therapy made it."""


def beside_norms(
    norms: Norms, catalogue: Catalogue, rows: Sequence[TherapySession], pasts: Sequence[Past]
) -> tuple[Beside, ...]:
    """Numbers of the latest session that patients alike have too; none where nobody made norms.

    Args:
        norms: Norms of the clinic.
        catalogue: Where it stands when they were made.
        rows: Sessions of the patient.
        pasts: Those that were measured, oldest first.
    """
    kept = catalogue.setting(KEY)
    if kept is None or not pasts:
        return ()
    latest = pasts[-1]
    mode = next((row.mode for row in rows if row.id == latest.session_id), "")
    found = norms.beside(latest, mode)
    return tuple(
        Beside(
            norm.group.metric,
            norm.group.subject,
            latest.value(norm.group.metric, norm.group.subject),
            norm.low,
            norm.median,
            norm.high,
            in_words(norm),
            kept.created_utc_ns,
            definition(norm.group.metric).version,
        )
        for norm in sorted(
            found, key=lambda one: SHOWN.index(one.group.metric) if one.group.metric in SHOWN else 99
        )
        if norm.group.metric in SHOWN
    )
