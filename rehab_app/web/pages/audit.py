"""The audit: who did what, found by person, verb, subject and dates; as CSV; whether its chain is whole."""

from __future__ import annotations

from datetime import date, datetime, timedelta
from urllib.parse import urlencode

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.web.visit import Visit
from sessions.catalogue import AuditFilter

_ROWS = 100
_FIELDS = ("person", "verb", "subject", "from", "until")


def audit(visit: Visit) -> Response:
    """The page."""
    asked = _asked(visit)
    number = visit.request.query_params.get("page", "1")
    page = max(1, int(number)) if number.isascii() and number.isdecimal() and len(number) < 7 else 1
    service, sentence = visit.site.clinic.audit, ""
    try:
        wanted = _wanted(asked)
    except Refused as refusal:
        wanted, sentence = AuditFilter(), str(refusal)
    rows, total = service.find(visit.account, wanted, _ROWS * (page - 1), _ROWS)
    persons, verbs = service.words(visit.account)
    whole = visit.request.query_params.get("whole", "") == "yes"
    return visit.page(
        "audit.html.j2",
        status=400 if sentence else 200,
        rows=rows,
        total=total,
        page=page,
        pages=max(1, -(-total // _ROWS)),
        persons=persons,
        verbs=verbs,
        asked=asked,
        query=urlencode({key: value for key, value in asked.items() if value}),
        chain=service.state(visit.account) if whole else service.look(visit.account, rows),
        sentence=sentence,
    )


def download(visit: Visit) -> Response:
    """The rows that fit as a file."""
    text = visit.site.clinic.audit.csv(visit.account, _wanted(_asked(visit)))
    headers = {"content-disposition": 'attachment; filename="audit.csv"'}
    return Response(text.encode("utf-8-sig"), media_type="text/csv; charset=utf-8", headers=headers)


def _asked(visit: Visit) -> dict[str, str]:
    return {name: visit.request.query_params.get(name, "").strip()[:120] for name in _FIELDS}


def _wanted(asked: dict[str, str]) -> AuditFilter:
    until = _day(asked["until"])
    return AuditFilter(
        actor=asked["person"],
        verb=asked["verb"],
        subject=asked["subject"],
        from_utc_ns=_begin_ns(_day(asked["from"])),
        until_utc_ns=_begin_ns(until + timedelta(days=1) if until is not None else None),
    )


def _day(text: str) -> date | None:
    if not text:
        return None
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise Refused("date", repr(text[:40]), "a day as 2026-01-31", "choose one") from None


def _begin_ns(day: date | None) -> int:
    """When a day begins in the clinic's own time zone, UTC ns; 0 where none was chosen."""
    if day is None:
        return 0
    begin = datetime(day.year, day.month, day.day).astimezone()
    return max(0, round(begin.timestamp()) * 1_000_000_000)
