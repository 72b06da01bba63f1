"""Three plain sentences on progress; none credits the robot, and none calls a change what may be none."""

from __future__ import annotations

import math

from sessions.reports.language import _, counted, day
from sessions.reports.past import Past
from sessions.reports.progress import COMPARISON, Line, Progress, total
from sessions.reports.verdict import STRETCH_RAD, helped
from sessions.reports.wording import MISSING, joint_words


def progress_sentences(progress: Progress, leading: Line | None) -> tuple[str, str, str]:
    """What was done, how far the hand moves now, and what the patient started."""
    if not progress.pasts:
        return (
            _("No session was measured yet, so nothing can be said of progress."),
            _("How far the hand moves was not measured."),
            _("What you started yourself was not measured."),
        )
    return _done(progress), _moves(leading), _own(progress)


def _done(progress: Progress) -> str:
    pasts = progress.pasts
    if progress.title == COMPARISON:
        return _compared(pasts)
    made = counted("%(n)s repetition", "%(n)s repetitions", round(total(pasts, "repetitions")))
    minutes = total(pasts, "dose_time") / 60.0
    time = (
        counted("%(n)s minute", "%(n)s minutes", round(minutes))
        if minutes >= 0.5
        else _("less than a minute")
    )
    return _(
        "You had %(sessions)s %(when)s, with %(repetitions)s in %(time)s of movement.",
        sessions=counted("%(n)s session", "%(n)s sessions", len(pasts)),
        when=_when(pasts, _("from %(first)s to %(last)s")),
        repetitions=made,
        time=time,
    )


def _compared(pasts: tuple[Past, ...]) -> str:
    made = tuple(past.value("repetitions") for past in pasts)
    first, second = (MISSING if math.isnan(count) else f"{count:.0f}" for count in made)
    when = _when(pasts, _("on %(first)s and %(last)s"))
    return _(
        "Two of your sessions are compared here, %(when)s, with %(first)s and %(second)s repetitions.",
        when=when,
        first=first,
        second=second,
    )


def _when(pasts: tuple[Past, ...], of_two: str) -> str:
    first, last = (day(past.utc_start_ns) for past in (pasts[0], pasts[-1]))
    return _("on %(day)s", day=first) if first == last else of_two % {"first": first, "last": last}


def _moves(leading: Line | None) -> str:
    if leading is None or leading.now.value is None:
        return _("How far the hand moves was not measured.")
    joint, now = joint_words(leading.subject), f"{math.degrees(leading.now.value):.0f}"
    if helped(leading.session):
        said = _("The robot moves your %(joint)s through %(angle)s°", joint=joint, angle=now)
    else:
        said = _("You now move your %(joint)s through %(angle)s°", joint=joint, angle=now)
    if leading.baseline is None or leading.baseline.value is None:
        return _("%(said)s; there is no earlier session to compare with.", said=said)
    compared = _(
        "%(said)s; it was %(angle)s° in the first session that can be compared",
        said=said,
        angle=f"{math.degrees(leading.baseline.value):.0f}",
    )
    return f"{compared}{_judged(leading)}"


def _judged(leading: Line) -> str:
    """What may be said of the difference, as the end of the sentence."""
    difference = leading.change.difference
    if leading.change.verdict == "not measurable":
        return _(", but whether that is a change cannot be told.")
    if leading.change.verdict == "below MDC":
        return _(": too small a difference to be sure of any change.")
    if abs(difference) <= STRETCH_RAD:
        return _(": a change as small as stretching alone makes.")
    angle = f"{abs(math.degrees(difference)):.0f}"
    if difference > 0:
        return _(": a real gain of %(angle)s°.", angle=angle)
    return _(": a real loss of %(angle)s°.", angle=angle)


def _own(progress: Progress) -> str:
    counts = [past for past in progress.pasts if _share(past) is not None]
    if not counts:
        return _("How many movements you started yourself was not measured.")
    latest = counts[-1]
    said = _("In the latest session you started %(own)s of %(made)s yourself", **_of(latest))
    alike = [past for past in counts[:-1] if past.modes == latest.modes]
    if not alike:
        return f"{said}."
    before, of = round(alike[0].value("repetitions_by_patient")), round(alike[0].value("repetitions"))
    return _(
        "%(said)s; in the first of that kind it was %(own)s of %(made)s.", said=said, own=before, made=of
    )


def _of(past: Past) -> dict[str, object]:
    own, made = round(past.value("repetitions_by_patient")), round(past.value("repetitions"))
    return {"own": own, "made": counted("%(n)s repetition", "%(n)s repetitions", made)}


def _share(past: Past) -> float | None:
    """Part of the repetitions that the patient started; None where it was not asked of them."""
    made, own = past.value("repetitions"), past.value("repetitions_by_patient")
    if "passive" in past.modes or math.isnan(own) or not made > 0:
        return None
    return own / made
