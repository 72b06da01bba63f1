"""People: patients and accounts."""

from __future__ import annotations

import sys
from dataclasses import asdict
from typing import Annotated, TypeAlias

import typer

from rehab_app.cli.options import Data, Json, Side
from rehab_app.cli.output import Output
from rehab_app.cli.refusals import Commands

patient = typer.Typer(cls=Commands, help="Patients of the clinic.", no_args_is_help=True)
user = typer.Typer(cls=Commands, help="Accounts of the clinic.", no_args_is_help=True)
_ROLES = "administrator, therapist, assistant, patient or auditor."
Name: TypeAlias = Annotated[str, typer.Argument(metavar="NAME", help="Sign-in name.")]
OwnPatient: TypeAlias = Annotated[
    str, typer.Option("--patient", help="Whose screen it is, by pseudonym; with the role patient.")
]


@patient.command("add")
def add_patient(
    given: Annotated[str, typer.Option("--given", help="Given name.")],
    family: Annotated[str, typer.Option("--family", help="Family name.")],
    birth_date: Annotated[str, typer.Option("--birth-date", help="As 1950-12-31.")],
    side: Side,
    hand_length: Annotated[
        float, typer.Option("--hand-length", help="Wrist crease to middle fingertip, m.")
    ] = 0.189,
    impairment: Annotated[str, typer.Option("--impairment", help="A note.")] = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Add a patient; files will know the pseudonym only."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        alike = clinic.patients.namesakes(given, family, birth_date)
        added = clinic.patients.add(
            CONSOLE,
            given_name=given,
            family_name=family,
            birth_date=birth_date,
            side=side,
            hand_length_m=hand_length,
            impairment=impairment,
        )
    if alike:
        names = ", ".join(one.id for one in alike)
        output.say(f"Warning: same name or birth date as {names}: make sure that they are different persons.")
    output.say(f"Patient {added.id} is added.")
    output.result({**asdict(added), "namesakes": [one.id for one in alike]})


@patient.command("list")
def list_patients(data: Data = None, json: Json = False) -> None:
    """List the patients."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        rows = clinic.patients.list()
    for row in rows:
        output.say(f"{row.id}  {row.family_name}, {row.given_name}  {row.birth_date}  {row.side} hand")
    output.result({"patients": [asdict(row) for row in rows]})


@user.command("add")
def add_user(
    name: Name,
    role: Annotated[str, typer.Option("--role", help=_ROLES)] = "therapist",
    patient: OwnPatient = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Make an account; the password is asked for, or read from stdin where that is no terminal."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    password = _password()
    with open_clinic(data) as clinic:
        account = clinic.accounts.add_user(name, role, password, CONSOLE, patient)
        screen = clinic.accounts.own_patients.of(account)
    output.say(f"{account.name} may sign in as {account.role}{f', screen of {screen}' if screen else ''}.")
    output.result({"name": account.name, "role": account.role, "patient": screen})


@user.command("list")
def list_users(data: Data = None, json: Json = False) -> None:
    """List the accounts."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        accounts = clinic.accounts.list(CONSOLE)
        rows = [(one.name, one.role, clinic.accounts.own_patients.of(one)) for one in accounts]
    for row in rows:
        output.say("  ".join(part for part in row if part))
    output.result({"users": [{"name": name, "role": role, "patient": own} for name, role, own in rows]})


@user.command("role")
def change_role(
    name: Name,
    role: Annotated[str, typer.Argument(metavar="ROLE", help=_ROLES)],
    patient: OwnPatient = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Give an account another role, or another patient; it is signed out everywhere."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        account = clinic.accounts.change_role(name, role, CONSOLE, patient)
        screen = clinic.accounts.own_patients.of(account)
    whose = f", screen of {screen}," if screen else ""
    output.say(f"{account.name} is {account.role}{whose} now and signs in again.")
    output.result({"name": account.name, "role": account.role, "patient": screen})


@user.command("password")
def reset_password(name: Name, data: Data = None, json: Json = False) -> None:
    """Give an account a new password, asked for or read from stdin; it is signed out everywhere."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    password = _password()
    with open_clinic(data) as clinic:
        clinic.accounts.reset_password(name, password, CONSOLE)
    output.say(f"{name} has a new password and signs in again.")
    output.result({"name": name})


@user.command("close")
def close_user(name: Name, data: Data = None, json: Json = False) -> None:
    """Close an account: it may sign in no more; what it did stays in the audit."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        clinic.accounts.close(name, CONSOLE)
    output.say(f"The account {name} is closed.")
    output.result({"name": name, "closed": True})


def _password() -> str:
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip("\n")
    return str(typer.prompt("Password", hide_input=True, confirmation_prompt=True, err=True))
