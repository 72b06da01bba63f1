"""The demo's own clinic: a sample patient, a take and sessions to review, and a sign-in that only it has."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import check_port, open_clinic
from rehab_app.cli.output import Output
from rehab_app.cli.serving import shown
from rehab_app.config import Settings
from rehab_app.services.clinic import Clinic
from rehab_app.services.walkthrough import walk

NAME = "demo"
_SIGN_IN = "demo-sign-in.txt"


def open_demo_clinic(folder: Path, host: str, port: int, seconds: float, seed: int, output: Output) -> None:
    """Fill the demo's clinic where it is empty, then serve it until it is interrupted.

    Args:
        folder: Folder of the demo's clinic.
        host: Address to listen on.
        port: Port to listen on.
        seconds: About how much therapy to simulate when it is filled.
        seed: Seed of everything random.
        output: Where to say things.

    Raises:
        Refused: The port is in use, or another server holds the folder.
    """
    check_port(host, port)
    with open_clinic(folder, serving=True, settings=Settings()) as clinic:  # never the clinic's own catalogue
        fill(clinic, seconds, seed, output)
        password = sign_in(clinic)
        from rehab_app.web import serve

        def ready() -> None:
            output.say(f"The clinic is open at http://{shown(host)}:{port}")
            output.say(
                f"Sign in as {NAME} with the password {password} (this demo's only). End it with Ctrl+C."
            )

        serve(clinic, host=host, port=port, ready=ready)


def fill(clinic: Clinic, seconds: float, seed: int, output: Output) -> None:
    """Make the sample patient, take and sessions where the clinic has no session yet."""
    patient_id = sample_patient(clinic)
    if not clinic.sessions.list():
        walk(clinic, seconds, seed, patient_id, output.say)


def sample_patient(clinic: Clinic) -> str:
    """Pseudonym of the sample patient, who is made up and added where the clinic has no patient yet."""
    known = clinic.patients.list()
    if known:
        return known[0].id
    made = clinic.patients.add(
        CONSOLE,
        given_name="Sample",
        family_name="Patient",
        birth_date="1957-03-14",
        side="right",
        hand_length_m=0.185,
        impairment="Made up for the demo: weak grasp, opening harder than closing.",
    )
    return made.id


def sign_in(clinic: Clinic) -> str:
    """Password of the demo's therapist: drawn once, kept in the private demo folder."""
    kept = clinic.folder / _SIGN_IN
    if not kept.exists():
        password = "-".join(secrets.token_hex(2) for _ in range(3))
        clinic.accounts.add_user(NAME, "therapist", password, CONSOLE)
        descriptor = os.open(kept, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="ascii") as file:
            file.write(password)
    return kept.read_text(encoding="ascii").strip()
