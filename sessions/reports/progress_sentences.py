"""Three plain sentences on progress; none credits the robot, and none calls a change what may be none."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from sessions.reports.past import Past
from sessions.reports.progress import Line, Progress, total
from sessions.reports.verdict import STRETCH_RAD, helped
from sessions.reports.wording import joint_words, plural


def progress_sentences(progress: Progress, leading: Line | None) -> tuple[str, str, str]:
    """What was done, how far the hand moves now, and what the patient started."""
    if not progress.pasts:
        nothing = "No session was measured yet, so nothing can be said of progress."
        return (
            nothing,
            "How far the hand moves was not measured.",
            "What you started yourself was not measured.",
        )
    return _done(progress), _moves(leading), _own(progress)


def _done(progress: Progress) -> str:
    pasts = progress.pasts
    made = total(pasts, "repetitions")
    minutes = total(pasts, "dose_time") / 60.0
    first, last = (
        datetime.fromtimestamp(past.utc_start_ns // 1_000_000_000, tz=UTC) for past in (pasts[0], pasts[-1])
    )
    when = f"on {first:%d %B %Y}" if first.date() == last.date() else f"from {first:%d %B} to {last:%d %B %Y}"
    if progress.title != "Progress":
        when = (
            f"on {first:%d %B %Y}" if first.date() == last.date() else f"on {first:%d %B} and {last:%d %B %Y}"
        )
        made = " and ".join(f"{past.value('repetitions'):.0f}" for past in pasts)
        return f"Two of your sessions are compared here, {when}, with {made} repetitions."
    return (
        f"You had {plural(len(pasts), 'session')} {when}, with {plural(round(made), 'repetition')} in "
        f"{plural(round(minutes), 'minute') if minutes >= 0.5 else 'less than a minute'} of movement."
    )


def _moves(leading: Line | None) -> str:
    if leading is None or leading.now.value is None:
        return "How far the hand moves was not measured."
    joint, now = joint_words(leading.subject), math.degrees(leading.now.value)
    how = "The robot moves your" if helped(leading.session) else "You now move your"
    said = f"{how} {joint} through {now:.0f}°"
    if leading.baseline is None or leading.baseline.value is None:
        return f"{said}; there is no earlier session to compare with."
    before, difference = math.degrees(leading.baseline.value), leading.change.difference
    compared = f"it was {before:.0f}° in the first session that can be compared"
    if leading.change.verdict == "not measurable":
        return f"{said}; {compared}, but whether that is a change cannot be told."
    if leading.change.verdict == "below MDC":
        return f"{said}; {compared}: too small a difference to be sure of any change."
    if abs(difference) <= STRETCH_RAD:
        return f"{said}; {compared}: a change as small as stretching alone makes."
    gained = "gain" if difference > 0 else "loss"
    return f"{said}; {compared}: a real {gained} of {abs(math.degrees(difference)):.0f}°."


def _own(progress: Progress) -> str:
    counted = [past for past in progress.pasts if _share(past) is not None]
    if not counted:
        return "How many movements you started yourself was not measured."
    latest = counted[-1]
    own, made = round(latest.value("repetitions_by_patient")), round(latest.value("repetitions"))
    said = f"In the latest session you started {own} of {plural(made, 'repetition')} yourself"
    alike = [past for past in counted[:-1] if past.modes == latest.modes]
    if not alike:
        return f"{said}."
    first = alike[0]
    before, of = round(first.value("repetitions_by_patient")), round(first.value("repetitions"))
    return f"{said}; in the first of that kind it was {before} of {of}."


def _share(past: Past) -> float | None:
    """Part of the repetitions that the patient started; None where it was not asked of them."""
    made, own = past.value("repetitions"), past.value("repetitions_by_patient")
    if "passive" in past.modes or math.isnan(own) or not made > 0:
        return None
    return own / made
