"""Progress over sessions as blocks: three sentences, one picture, the clinician's tables, charts, method."""

from __future__ import annotations

from sessions.reports.assessed import NO_GRADE, tone_words
from sessions.reports.beside import norm_blocks
from sessions.reports.language import _, counted, decimal, marked, short_day
from sessions.reports.letterhead import letterhead
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
from sessions.reports.remarks import remark
from sessions.reports.wording import exercise_words, hand, joint_name, mode_words

_LIMITS = (
    marked(
        "Real: the change is larger than the minimal detectable change (MDC) of this set-up or, where that"
        " was not measured, than the one published for this kind of measurement, and than both intervals "
        "together. Below MDC: nothing can be said. Not measurable: the sessions may not be compared, for "
        "the reason in the note."
    ),
    marked(
        "A detectable change is not yet an important one: published minimal important differences stand "
        "beside the scores that the clinic takes. For numbers measured by a robot or a camera none is "
        "published, so no change of these is called important."
    ),
    marked("Stretching alone gains about 2 degrees: a gain of that size is credited to nothing and nobody."),
    marked(
        "A range that the robot moved the hand through is the robot's, not the patient's; the two are never "
        "compared."
    ),
    marked(
        "Errors against the therapist are compared only at stiffness within 10 % of each other: a stiff "
        "robot makes anyone look good."
    ),
    marked("Angles are compared only where the same kind of sensor measured them by the same method."),
)


def progress_paper(progress: Progress) -> Paper:
    """Progress, or the comparison of two sessions where the progress holds just those."""
    title = f"{_(progress.title)} {progress.subject_id}"
    leading = leading_line(progress)
    first: list[Block] = [Facts(_facts(progress)), Plain(progress_sentences(progress, leading))]
    drawn = leading_picture(progress, leading, "lead")
    if leading is not None and drawn:
        caption = _(
            "%(joint)s: range by %(source)s, session by session, with 95 %% intervals. Inside the band no "
            "change from the first comparable session can be told.",
            joint=joint_name(leading.subject),
            source=remark(leading.now.source),
        )
        first.append(Picture(drawn, caption, caption))
    else:
        first.append(Picture("", _("No range of motion was measured, so there is no picture.")))
    blocks = (*first, Break(), *_clinician(progress), *_charts(progress), Break(), *_method(progress))
    return Paper(title, (Part(_(progress.title), blocks),), progress.software_version)


def _clinician(progress: Progress) -> list[Block]:
    judgements = Judgements()
    tables = judged_tables(progress, judgements)
    blocks: list[Block] = [Heading(_("For the clinician")), *(Numbers(table) for table in tables)]
    if not tables:
        blocks.append(Hint(_("No number was measured in any session."), missing=True))
    blocks += [Notes(tuple(judgements.texts)), overall_words(progress)]
    blocks += [*_assessed(progress), *norm_blocks(progress), *_scores(progress)]
    if progress.left_out:
        texts = tuple(f"{short_day(item.utc_start_ns)}: {remark(item.reason)}" for item in progress.left_out)
        blocks += [Heading(_("Sessions that take no part"), 3), Bullets(texts)]
    return blocks


def _scores(progress: Progress) -> list[Block]:
    """The clinic's own scores, as the clinic entered them."""
    if not progress.scores:
        return []
    rows = tuple(
        (
            remark(item.name),
            *(decimal(_(text)) for text in (item.baseline, item.last, item.now, item.change)),
            remark(item.meaning),
        )
        for item in progress.scores
    )
    columns = (
        _("Score taken by the clinic"),
        _("Baseline"),
        _("Last"),
        _("Now"),
        _("Change"),
        _("What it means"),
    )
    return [Heading(_("Scores"), 3), Words(columns, rows)]


def _assessed(progress: Progress) -> list[Block]:
    """What the guided assessments found, beside what nobody published for them."""
    judgements = Judgements()
    tables, tone = assessed_tables(progress, judgements), tone_words(progress.tones)
    blocks: list[Block] = []
    if tables:
        blocks += [Heading(_("Range assessments"), 3), *(Numbers(table) for table in tables)]
        blocks += [Notes(tuple(judgements.texts))] if judgements.texts else []
    if tone is not None:
        blocks += [Heading(_("Tone, stretched at several speeds"), 3), tone, Hint(_(NO_GRADE))]
    return blocks


def _charts(progress: Progress) -> list[Block]:
    drawn = (
        (
            ranges_picture(progress, "range"),
            _(
                "Range of motion. Filled circles: the patient moved; open squares: the robot moved. Bars: "
                "95 % interval. Band: within it no change can be told."
            ),
        ),
        (
            support_picture(progress, "support"),
            _(
                "Joint error against the therapist, and the stiffness it was obtained at. A fall of the "
                "error together with a rise of the stiffness says nothing of the patient."
            ),
        ),
        (
            dose_picture(progress, "dose"),
            _("Repetitions; hatched: started by the patient. Dashed: the plan."),
        ),
        (pain_picture(progress, "pain"), _("Pain as it was told.")),
    )
    blocks: list[Block] = [Picture(svg, caption, caption) for svg, caption in drawn if svg]
    return [Heading(_("Charts")), *blocks] if blocks else []


def _method(progress: Progress) -> list[Block]:
    names = [
        name
        for name in ALL_NAMES
        if any(item.name == name for past in progress.pasts for item in past.numbers)
    ]
    columns = (_("Session"), _("File SHA-256"), _("Exercise"), _("Mode"), _("Stiffness"))
    return [
        Heading(_("How it was measured")),
        definitions(names),
        Heading(_("Limits of these numbers"), 3),
        Bullets(tuple(_(text) for text in _LIMITS)),
        Heading(_("Where the numbers come from"), 3),
        Words(columns, tuple(_source(number, past) for number, past in enumerate(progress.pasts, 1))),
    ]


def _source(number: int, past: Past) -> tuple[str, ...]:
    return (
        f"{number}: {short_day(past.utc_start_ns)}",
        past.sha256,
        exercise_words(past.exercise),
        ", ".join(_(mode) for mode in past.modes) or _("not recorded"),
        remark(past.conditions.rpartition(", ")[0] or past.conditions) or _("not recorded"),
    )


def _facts(progress: Progress) -> tuple[tuple[str, str], ...]:
    pasts = progress.pasts
    sources = dict.fromkeys(item.source for past in pasts for item in past.numbers if item.source)
    ends = [short_day(past.utc_start_ns) for past in (pasts[:1] + pasts[-1:])]
    modes = dict.fromkeys(mode for past in pasts for mode in past.modes)
    left = _(", %(n)s left out", n=len(progress.left_out)) if progress.left_out else ""
    return (
        *letterhead(),
        (_("Patient"), f"{progress.subject_id}, {hand(progress.side)}"),
        (_("Sessions"), f"{counted('%(n)s session', '%(n)s sessions', len(pasts))}{left}"),
        (_("From, to"), " – ".join(dict.fromkeys(ends)) or _("none")),
        (_("Angles measured by"), ", ".join(remark(source) for source in sources) or _("nothing")),
        (_("Modes"), mode_words(modes) if modes else _("none")),
        (
            _("Detectable change"),
            _("measured with this set-up") if progress.bounds else _("as published"),
        ),
    )
