"""The latest session beside the norms of the clinic: where a number stands among patients alike."""

from __future__ import annotations

from sessions.metrics import definition
from sessions.reports.language import _, marked, short_day
from sessions.reports.paper import Block, Heading, Hint, Words
from sessions.reports.progress import Beside, Progress
from sessions.reports.remarks import remark
from sessions.reports.tables import heading
from sessions.reports.wording import number, span, subject_name

_READ = marked(
    "Patients alike: same decade of age, side of the hand, diagnosis, mode and sensor; each counts once, "
    "with the first session. A place among them is no judgement of health, and few patients make a wide "
    "norm."
)


def norm_blocks(progress: Progress) -> list[Block]:
    """A table with its citations; nothing where the clinic has no norm for such a patient."""
    if not progress.norms:
        return []
    columns = (
        _("Latest session beside patients alike"),
        _("Now"),
        _("Median"),
        _("5 to 95 of 100 patients"),
        _("Place"),
        _("Norm"),
    )
    return [
        Heading(_("Beside patients alike of this clinic"), 3),
        Words(columns, tuple(_row(one) for one in progress.norms)),
        Hint(_(_READ)),
    ]


def _row(one: Beside) -> tuple[str, ...]:
    def shown(value: float) -> str:
        return number(one.name, definition(one.name).unit, value)

    cited = _(
        "%(cited)s; made %(day)s, method %(version)s",
        cited=remark(one.cited),
        day=short_day(one.made_utc_ns),
        version=one.version,
    )
    return (
        f"{heading(one.name)}, {subject_name(one.subject)}",
        shown(one.value),
        shown(one.median),
        span(shown(one.low), shown(one.high)),
        _place(one),
        cited,
    )


def _place(one: Beside) -> str:
    if one.value < one.low:
        return _("below")
    return _("above") if one.value > one.high else _("within")
