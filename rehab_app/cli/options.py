"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

# Words of robot_iface.types, whose import would slow --help down; a test keeps both equal.
TWINS = "healthy, flaccid, weak, mas1+, mas2, mas3, contracture, tremor, clonus, slacking, resisting, tiring"
MODES = "passive, assistive, transparent, resistive"
SPACES = "joint, fingertip"

Json: TypeAlias = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, SI units.")]
Data: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--data", help="Clinic folder (else REHAB_DATA, else the user's data folder).", show_default=False
    ),
]
Out: TypeAlias = Annotated[Path | None, typer.Option("--out", help="File to make.", show_default=False)]
Seed: TypeAlias = Annotated[int, typer.Option("--seed", help="Seed of everything random.")]
Take: TypeAlias = Annotated[str, typer.Argument(metavar="TAKE", help="Path or catalogue id of a take.")]
Side: TypeAlias = Annotated[str, typer.Option("--side", help="left or right.")]
Robot: TypeAlias = Annotated[str, typer.Option("--robot", help="Device.")]
Twin: TypeAlias = Annotated[
    str,
    typer.Option(
        "--virtual-patient",
        help="Who wears the simulated robot: " + TWINS + ".",
        show_default="by the clinical record, else healthy",
    ),
]
WristDegrees: TypeAlias = Annotated[
    float, typer.Option("--wrist-deg", help="Extension at which the wrist is held, degrees.")
]
PatientId: TypeAlias = Annotated[str, typer.Argument(metavar="PATIENT", help="Patient id.")]
By: TypeAlias = Annotated[str, typer.Option("--by", help="Account that does it.", show_default="the console")]
Realtime: TypeAlias = Annotated[bool, typer.Option("--realtime", help="On the wall clock.")]
Confirm: TypeAlias = Annotated[
    str, typer.Option("--confirm-device", help="A real device by its name: you looked at it and the patient.")
]
Present: TypeAlias = Annotated[
    str | None,
    typer.Option("--present", help="Id of who sits at the robot, asked of the person.", show_default=False),
]
