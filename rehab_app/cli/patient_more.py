"""What is written about a patient: search, notes, pain, adverse events, outcome measures."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from rehab_app.cli.options import By, Data, Json, PatientId
from rehab_app.cli.output import Output
from rehab_app.cli.people import patient
from rehab_app.cli.refusals import Commands

if TYPE_CHECKING:
    from rehab_app.services.journal import Entry
    from rehab_app.services.outcomes import Series

outcome = typer.Typer(cls=Commands, help="Outcome measures of a patient.", no_args_is_help=True)

Corrects: TypeAlias = Annotated[
    int, typer.Option("--corrects", help="Number of the entry that this one takes the place of.", min=0)
]
Session: TypeAlias = Annotated[str, typer.Option("--session", help="Session that it belongs to.")]


@patient.command("find")
def find(
    words: Annotated[str, typer.Argument(metavar="WORDS", help="Of name, birth date or pseudonym.")] = "",
    archived: Annotated[bool, typer.Option("--archived", help="Among the archived ones.")] = False,
    page: Annotated[int, typer.Option("--page", help="Page of 50, from 1.", min=1)] = 1,
    data: Data = None,
    json: Json = False,
) -> None:
    """Find patients; accents, case and the way of writing the date do not matter."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        found = clinic.patients.search(words, archived=archived, page=page)
    for row in found.patients:
        output.say(f"{row.id}  {row.family_name}, {row.given_name}  {row.birth_date}  {row.side} hand")
    output.say(f"{found.total} found, page {found.page} of {found.pages}.")
    rows = [asdict(row) for row in found.patients]
    output.result({"patients": rows, "total": found.total, "page": found.page, "pages": found.pages})


@patient.command("archive")
def archive(
    patient_id: PatientId,
    back: Annotated[bool, typer.Option("--back", help="Put the patient back into the lists.")] = False,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Take a patient out of the lists; nothing is lost."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        act = clinic.patients.unarchive if back else clinic.patients.archive
        kept = act(acting(clinic, by), patient_id)
    output.say(f"{kept.id} is {'archived' if kept.archived else 'in the lists'}.")
    output.result({"patient": kept.id, "archived": kept.archived})


@patient.command("note")
def note(
    patient_id: PatientId,
    text: Annotated[str, typer.Argument(metavar="TEXT", help="The note.")],
    session: Session = "",
    corrects: Corrects = 0,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Write a note into the journal."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        kept = clinic.journal.note(actor, patient_id, text, session=session, corrects=corrects)
    _tell(Output(json), kept)


@patient.command("pain")
def pain(
    patient_id: PatientId,
    score: Annotated[int, typer.Option("--score", help="0 (none) to 10 (worst).")],
    place: Annotated[str, typer.Option("--place", help="Where it hurts.")] = "",
    when: Annotated[str, typer.Option("--when", help="before, during, after or rest.")] = "",
    remark: Annotated[str, typer.Option("--remark", help="Anything else.")] = "",
    session: Session = "",
    corrects: Corrects = 0,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Write a pain into the journal."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.services.journal import PainReport

    report = PainReport(score, place, when, remark)
    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        kept = clinic.journal.pain(actor, patient_id, report, session=session, corrects=corrects)
    _tell(Output(json), kept)


@patient.command("event")
def event(
    patient_id: PatientId,
    happened: Annotated[str, typer.Option("--happened", help="What happened.")],
    done: Annotated[str, typer.Option("--done", help="What was done about it.")],
    severity: Annotated[str, typer.Option("--severity", help="mild, moderate or severe.")],
    session: Session = "",
    corrects: Corrects = 0,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Write an adverse event into the journal."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.services.journal import AdverseEvent

    told = AdverseEvent(severity, happened, done)
    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        kept = clinic.journal.adverse_event(actor, patient_id, told, session=session, corrects=corrects)
    _tell(Output(json), kept)


@patient.command("journal")
def journal(patient_id: PatientId, data: Data = None, json: Json = False) -> None:
    """List notes, pain, adverse events and check-ins, newest first."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        entries = clinic.journal.entries(patient_id)
    for one in entries:
        said = ", ".join(
            f"{name} {value}" for name, value in asdict(one.what).items() if value not in ("", None)
        )
        gone = f"  (corrected by {one.corrected_by})" if one.corrected_by else ""
        output.say(f"{one.id}  {one.kind} by {one.by}: {said}{gone}")
    output.result({"patient": patient_id, "entries": [asdict(one) for one in entries]})


@outcome.command("add")
def add_outcome(
    patient_id: PatientId,
    measure: Annotated[str, typer.Argument(metavar="MEASURE", help="See `patient outcome measures`.")],
    value: Annotated[str, typer.Argument(metavar="VALUE", help="As it is read: degrees, kg, s, a grade.")],
    side: Annotated[str, typer.Option("--side", help="Hand that was tested: left or right.")] = "",
    place: Annotated[str, typer.Option("--place", help="Joint, digit or kind of grip.")] = "",
    date: Annotated[
        str, typer.Option("--date", help="When it was measured, as 2026-12-31.", show_default="today")
    ] = "",
    remark: Annotated[str, typer.Option("--remark", help="Anything else.")] = "",
    corrects: Corrects = 0,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Enter a value of an outcome measure."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.services.outcome_measures import measure as measure_of

    output = Output(json)
    chosen = measure_of(measure)
    read = chosen.read(value)
    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        kept = clinic.outcomes.add(
            actor, patient_id, measure, read,
            side=side, place=place, measured_on=date, remark=remark, corrects=corrects,
        )  # fmt: skip
    output.say(f"Entry {kept.id}: {chosen.words} {chosen.text(kept.value)} {chosen.shown}".rstrip() + ".")
    output.result(asdict(kept))


@outcome.command("list")
def list_outcomes(patient_id: PatientId, data: Data = None, json: Json = False) -> None:
    """List first, last and newest value of every measure, hand and place."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        held = clinic.outcomes.series(patient_id)
    for one in held:
        first, now = one.measure.text(one.baseline.value), one.measure.text(one.now.value)
        where = " ".join(part for part in (one.measure.words, one.side, one.place) if part)
        output.say(f"{where}: {first} ({one.baseline.measured_on}) to {now} ({one.now.measured_on})")
    output.result({"patient": patient_id, "series": [_series(one) for one in held]})


@outcome.command("measures")
def measures(data: Data = None, json: Json = False) -> None:
    """List the measures with their ranges."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.services.outcome_measures import MEASURES

    output = Output(json)
    for one in MEASURES:
        places = f"; of {', '.join(one.places)}" if one.places else ""
        output.say(f"{one.key}: {one.words}, {one.range_text}, {one.better} is better{places}")
    output.result({"measures": [asdict(one) for one in MEASURES]})


def _tell(output: Output, entry: Entry) -> None:
    output.say(f"Entry {entry.id} ({entry.kind}) of {entry.patient} is written by {entry.by}.")
    output.result(asdict(entry))


def _series(one: Series) -> dict[str, object]:
    return {
        "measure": one.measure.key,
        "unit": one.measure.unit,
        "side": one.side,
        "place": one.place,
        "values": [asdict(row) for row in one.rows],
        "change": one.change,
        "direction": one.direction,
        "meaning": one.meaning,
    }
