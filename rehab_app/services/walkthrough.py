"""The whole loop on the virtual camera, the simulated exoskeleton and a virtual patient.

What happens::

    virtual camera ─▶ take ─▶ approval ─▶ reference ─▶ rehearsal ─▶ passive, then assistive ─▶ report
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rehab_app.access import CONSOLE
from rehab_app.errors import Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.order import Order
from rehab_app.services.rows import PreparedPlan, TakeRow
from rehab_app.therapy.run import PlayResult

EXERCISE = "open_close"
SPEED = 0.5
TAKE_S = 8.0
SHORTEST_S = 1.0
LONGEST_S = 3600.0
_OVERHEAD_S = 4.0  # approach, ramp, hold, return and rest around one movement


@dataclass(frozen=True, slots=True)
class Part:
    """One session of the loop.

    Attributes:
        mode: Therapy mode.
        twin: Kind of the virtual patient.
        stiffness_multiple: Stiffness as a multiple of the thesis gains.
    """

    mode: str
    twin: str
    stiffness_multiple: float


# assistance starts soft, so that the weak patient's own movement shows beside the robot's
PARTS = (Part("passive", "healthy", 3.0), Part("assistive", "weak", 1.5))


@dataclass(frozen=True, slots=True)
class Walk:
    """What the loop made.

    Attributes:
        take: The recorded take.
        sessions: The passive session, then the assistive one.
        report_html: Report of both sessions as a page.
        report_json: The same as JSON.
        wall_s: How long the loop took.
        simulated_s: Therapy time that was simulated.
    """

    take: TakeRow
    sessions: tuple[PlayResult, ...]
    report_html: Path
    report_json: Path
    wall_s: float
    simulated_s: float


def check_seconds(seconds: float) -> None:
    """Refuse a length that the loop cannot have, before a folder is made for it.

    Raises:
        Refused: It is not 1 to 3600 s.
    """
    if not SHORTEST_S <= seconds <= LONGEST_S:
        bound = f"{SHORTEST_S:g} to {LONGEST_S:g} s"
        raise Refused("demo length", f"{seconds:g} s", bound, "choose --seconds within it")


def walk(
    clinic: Clinic, seconds: float, seed: int, patient_id: str | None, say: Callable[[str], None]
) -> Walk:
    """Record, approve, rehearse, play passive then assistive, measure, report.

    Args:
        clinic: Where it all goes.
        seconds: About how much therapy to simulate, 1 to 3600 s; each mode makes at least one repetition.
        seed: Seed of everything random.
        patient_id: Patient, None for a bare demonstration.
        say: Told what is going on.
    """
    began_s = time.monotonic()
    say("Recording the therapist's hand before the virtual camera.")
    recorded = clinic.takes.record_virtual(EXERCISE, "right", TAKE_S, seed, CONSOLE)
    clinic.takes.approve(recorded.take, CONSOLE)
    results: list[PlayResult] = []
    for part in PARTS:
        prepared = _plan(clinic, recorded.take, patient_id, part, seconds, seed)
        times = prepared.plan.prescription.repetitions
        say(f"Playing {times} times in {part.mode} mode on a {part.twin} virtual patient.")
        results.append(clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE))
    say("Measuring and writing the report.")
    html, json = clinic.reports.report(
        [result.session for result in results], ("html", "json"), actor=CONSOLE
    )
    return Walk(
        clinic.takes.get(recorded.take),
        tuple(results),
        html,
        json,
        time.monotonic() - began_s,
        sum(result.simulated_s for result in results),
    )


def _plan(
    clinic: Clinic, take: str, patient_id: str | None, part: Part, seconds: float, seed: int
) -> PreparedPlan:
    """A plan whose repetitions fill about half of the asked time."""

    def planned(repetitions: int) -> PreparedPlan:
        order = Order(
            mode=part.mode,
            speed=SPEED,
            repetitions=repetitions,
            twin=part.twin,
            seed=seed,
            stiffness_multiple=part.stiffness_multiple,
        )
        return clinic.therapy.plan(take, order, actor=CONSOLE, patient_id=patient_id)

    once = planned(1)
    repetition_s = once.plan.path_s / once.plan.prescription.speed + _OVERHEAD_S
    return planned(min(500, max(1, math.floor(0.5 * seconds / repetition_s))))
