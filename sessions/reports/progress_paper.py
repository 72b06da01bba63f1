"""Progress over sessions as blocks: three sentences, one picture, the clinician's tables, charts, method."""

from __future__ import annotations

from datetime import UTC, datetime

from sessions.reports.assessed import NO_GRADE, tone_words
from sessions.reports.method import definitions
from sessions.reports.paper import (
    Block,
    Break,
    Bullets,
    Facts,
    Heading,
    Hint,
    Notes,
    Numbers,
    Paper,
    Part,
    Picture,
    Plain,
    Words,
)
from sessions.reports.past import Past
from sessions.reports.progress import Progress, leading_line
from sessions.reports.progress_figures import (
    dose_picture,
    leading_picture,
    pain_picture,
    ranges_picture,
    support_picture,
)
from sessions.reports.progress_sentences import progress_sentences
from sessions.reports.progress_tables import (
    ALL_NAMES,
    Judgements,
    assessed_tables,
    judged_tables,
    overall_words,
)
from sessions.reports.wording import joint_name, plural

_LIMITS = (
    "Real: the change is larger than the minimal detectable change (MDC) of this set-up or, where that was "
    "not measured, than the one published for this kind of measurement, and than both intervals together. "
    "Below MDC: nothing can be said. Not measurable: the sessions may not be compared, for the reason in "
    "the note.",
    "A detectable change is not yet an important one: published minimal important differences stand beside "
    "the scores that the clinic takes. For numbers measured by a robot or a camera none is published, so no "
    "change of these is called important.",
    "Stretching alone gains about 2 degrees: a gain of that size is credited to nothing and nobody.",
    "A range that the robot moved the hand through is the robot's, not the patient's; the two are never "
    "compared.",
    "Errors against the therapist are compared only at stiffness within 10 % of each other: a stiff robot "
    "makes anyone look good.",
    "Angles are compared only where the same kind of sensor measured them by the same method.",
)


def progress_paper(progress: Progress) -> Paper:
    """Progress, or the comparison of two sessions where the progress holds just those."""
    title = f"{progress.title} {progress.subject_id}"
    leading = leading_line(progress)
    first: list[Block] = [Facts(_facts(progress)), Plain(progress_sentences(progress, leading))]
    drawn = leading_picture(progress, leading, "lead")
    if leading is not None and drawn:
        caption = (
            f"{joint_name(leading.subject)}: range by {leading.now.source}, session by session, with 95 % "
            "intervals. Inside the band no change from the first comparable session can be told."
        )
        first.append(Picture(drawn, caption, caption))
    else:
        first.append(Picture("", "No range of motion was measured, so there is no picture."))
    blocks = (*first, Break(), *_clinician(progress), *_charts(progress), Break(), *_method(progress))
    return Paper(title, (Part(progress.title, blocks),), progress.software_version)


def _clinician(progress: Progress) -> list[Block]:
    judgements = Judgements()
    tables = judged_tables(progress, judgements)
    blocks: list[Block] = [Heading("For the clinician"), *(Numbers(table) for table in tables)]
    if not tables:
        blocks.append(Hint("No number was measured in any session.", missing=True))
    blocks += [Notes(tuple(judgements.texts)), overall_words(progress)]
    blocks += _assessed(progress)
    if progress.scores:
        rows = tuple(
            (item.name, item.baseline, item.last, item.now, item.change, item.meaning)
            for item in progress.scores
        )
        columns = ("Score taken by the clinic", "Baseline", "Last", "Now", "Change", "What it means")
        blocks += [Heading("Scores", 3), Words(columns, rows)]
    if progress.left_out:
        texts = tuple(f"{day(item.utc_start_ns)}: {item.reason}" for item in progress.left_out)
        blocks += [Heading("Sessions that take no part", 3), Bullets(texts)]
    return blocks


def _assessed(progress: Progress) -> list[Block]:
    """What the guided assessments found, beside what nobody published for them."""
    judgements = Judgements()
    tables, tone = assessed_tables(progress, judgements), tone_words(progress.tones)
    blocks: list[Block] = []
    if tables:
        blocks += [Heading("Range assessments", 3), *(Numbers(table) for table in tables)]
        blocks += [Notes(tuple(judgements.texts))] if judgements.texts else []
    if tone is not None:
        blocks += [Heading("Tone, stretched at several speeds", 3), tone, Hint(NO_GRADE)]
    return blocks


def _charts(progress: Progress) -> list[Block]:
    drawn = (
        (
            ranges_picture(progress, "range"),
            "Range of motion. Filled circles: the patient moved; open squares: the robot moved. Bars: 95 % "
            "interval. Band: within it no change can be told.",
        ),
        (
            support_picture(progress, "support"),
            "Joint error against the therapist, and the stiffness it was obtained at. A fall of the error "
            "together with a rise of the stiffness says nothing of the patient.",
        ),
        (dose_picture(progress, "dose"), "Repetitions; hatched: started by the patient. Dashed: the plan."),
        (pain_picture(progress, "pain"), "Pain as it was told."),
    )
    blocks: list[Block] = [Picture(svg, caption, caption) for svg, caption in drawn if svg]
    return [Heading("Charts"), *blocks] if blocks else []


def _method(progress: Progress) -> list[Block]:
    names = [
        name
        for name in ALL_NAMES
        if any(item.name == name for past in progress.pasts for item in past.numbers)
    ]
    columns = ("Session", "File SHA-256", "Exercise", "Mode", "Stiffness")
    return [
        Heading("How it was measured"),
        definitions(names),
        Heading("Limits of these numbers", 3),
        Bullets(_LIMITS),
        Heading("Where the numbers come from", 3),
        Words(columns, tuple(_source(number, past) for number, past in enumerate(progress.pasts, 1))),
    ]


def _source(number: int, past: Past) -> tuple[str, ...]:
    return (
        f"{number}: {day(past.utc_start_ns)}",
        past.sha256,
        past.exercise or "not named",
        ", ".join(past.modes) or "not recorded",
        past.conditions or "not recorded",
    )


def _facts(progress: Progress) -> tuple[tuple[str, str], ...]:
    pasts = progress.pasts
    sources = dict.fromkeys(item.source for past in pasts for item in past.numbers if item.source)
    span = f"{day(pasts[0].utc_start_ns)} to {day(pasts[-1].utc_start_ns)}" if pasts else "none"
    modes = dict.fromkeys(mode for past in pasts for mode in past.modes)
    left = f", {len(progress.left_out)} left out" if progress.left_out else ""
    return (
        ("Patient", f"{progress.subject_id}, {progress.side} hand"),
        ("Sessions", f"{plural(len(pasts), 'session')}{left}"),
        ("From, to", span),
        ("Angles measured by", ", ".join(sources) or "nothing"),
        ("Modes", ", ".join(modes) or "none"),
        (
            "Detectable change",
            "measured with this set-up" if progress.bounds else "as published",
        ),
    )


def day(utc_ns: int) -> str:
    """A day in UTC, as people write it."""
    return f"{datetime.fromtimestamp(utc_ns // 1_000_000_000, tz=UTC):%d %b %Y}"
