"""propose: the next step for every exercise of a patient's plan, and the therapist's answer to it."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from rehab_app.cli.options import By, Data, Json, PatientId
from rehab_app.cli.output import Output


def propose(
    patient: PatientId,
    accept: Annotated[
        str, typer.Option("--accept", help="Proposal to accept: the plan is changed.", show_default=False)
    ] = "",
    decline: Annotated[str, typer.Option("--decline", help="Proposal to decline.", show_default=False)] = "",
    remark: Annotated[str, typer.Option("--remark", help="Why, in a few words.", show_default=False)] = "",
    aim: Annotated[
        float | None,
        typer.Option("--aim-percent", help="First aim at this share of successes.", show_default=False),
    ] = None,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Propose the next assistance, speed and range from the last sessions; accept or decline."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.errors import Refused

    output = Output(json)
    if accept and decline:
        raise Refused("answer", "both to accept and to decline", "one of them", "leave one out")
    with open_clinic(data) as clinic:
        actor, known = acting(clinic, by), clinic.patients.get(patient)
        if aim is not None:
            clinic.proposals.set_target(actor, aim / 100.0)
        if accept or decline:
            digest = _whole(accept or decline, [one.digest for one in clinic.proposals.of_patient(known.id)])
            clinic.proposals.answer(actor, known.id, digest, accept=bool(accept), remark=remark)
            output.say(f"Proposal {digest[:12]} is {'accepted' if accept else 'declined'}.")
        made = clinic.proposals.of_patient(known.id)
        answers, target = clinic.proposals.answers(known.id), clinic.proposals.target()
    for one in made:
        output.say(f"{one.digest[:12]}  {one.item.exercise} ({one.item.mode}): {one.step.why}")
    if not made:
        output.say("There is no plan, so nothing is proposed.")
    output.result(
        {
            "patient": known.id,
            "success_target": target,
            "proposals": [_plain(one) for one in made],
            "answers": [_answered(one) for one in answers],
        }
    )


def _plain(one: Any) -> dict[str, Any]:
    return {
        "proposal": one.digest,
        "item": one.item.key,
        "exercise": one.item.exercise,
        "mode": one.item.mode,
        "changes": _changes(one.changes),
        "why": one.step.why,
        "repetitions": one.known.repetitions,
        "successes": one.known.successes,
        "troubles": list(one.known.troubles),
        "sessions": list(one.known.sessions),
        "declined_by": one.declined_by,
    }


def _answered(one: Any) -> dict[str, Any]:
    return {
        "proposal": one.digest,
        "accepted": one.accepted,
        "exercise": one.exercise,
        "changes": _changes(one.changes),
        "why": one.why,
        "by": one.by,
        "remark": one.remark,
        "created_utc_ns": one.created_utc_ns,
    }


def _changes(changes: tuple[tuple[str, float, float], ...]) -> list[dict[str, Any]]:
    return [{"name": name, "now": now, "then": then} for name, now, then in changes]


def _whole(beginning: str, digests: list[str]) -> str:
    """The one digest that begins like this, else what was given."""
    fitting = [digest for digest in digests if digest.startswith(beginning)]
    return fitting[0] if len(fitting) == 1 else beginning
