"""The clinic's stations: what each said of itself last, how its clock stands, who is in therapy there."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rehab_app.cli.options import By, Data, Json
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.services.stations import StationState


def stations(by: By = "", data: Data = None, json: Json = False) -> None:
    """List the stations on this catalogue, how their clocks stand, and who is in therapy where."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        listed, own = clinic.stations.list(actor), clinic.stations.measure()
        name = clinic.stations.name
    if not listed:
        output.say("No station has said anything within 90 days: a station speaks while it serves.")
    for one in listed:
        output.say(line_of(one))
        if one.warning:
            output.say(f"      {one.warning}")
    output.result(
        {
            "here": {"name": name, "offset_ns": own.offset_ns, "uncertainty_ns": own.uncertainty_ns},
            "stations": [_row(one) for one in listed],
        }
    )


def line_of(state: StationState) -> str:
    """One line about a station."""
    from rehab_app.services.station_clock import offset_words

    heard = f"silent for {state.silent_s:.0f} s" if state.silent else "heard"
    treated = ", ".join(claim.patient for claim in state.patients)
    name = f"{state.station.name}{' (here)' if state.here else ''}"
    clock = f"clock {offset_words(state.clock)}"
    therapy = f", in therapy: {treated}" if treated else ""
    return f"{name}: {heard}, rehab-app {state.station.version}, {clock}{therapy}"


def _row(state: StationState) -> dict[str, Any]:
    said = {name: value for name, value in asdict(state.station).items() if name != "holder"}
    patients = [
        {"patient": one.patient, "since_utc_ns": one.since_utc_ns, "until_utc_ns": one.until_utc_ns}
        for one in state.patients
    ]
    seen = {"here": state.here, "silent_s": state.silent_s, "warning": state.warning}
    return {**said, **seen, "patients": patients}
