"""Rehearses a plan before anything moves: static checks, then a dry run on the twin.

What is refused: a path that leaves the range, the coupled range or the speed limits anywhere (also between
its knots), or brings thumb, fingers and palm too close; a law that could drive a hand which is to move by
itself; and a dry run in which the supervisor had to hold, yield or stop, or that did not come to its end.

What is not refused: a stiff hand that the permitted torque opens only in part. The control law's spring
saturates below the interaction limit, so such a session runs, opens as far as the limit lets it, and the
certificate says how near to the limit it came; only load beyond the limit trips.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np

from robot_iface.kinematics import patient_hand
from robot_iface.loop import SimulatedClock
from robot_iface.motion import QuinticPath, check_path
from robot_iface.rehearsal.envelope import first_driven
from robot_iface.rehearsal.observe import Observer
from robot_iface.runtime import Rig, ScriptedInbox, Surroundings, perform, plan_parts, seal
from robot_iface.safety import admit_limits
from robot_iface.sim import simulated
from robot_iface.types import Capabilities, Certificate, Plan, RunEnd, Sweep

REHEARSED_REPETITIONS = 2
"""Repetitions of the dry run: the second already carries what the first has taught."""
_REHEARSED_HOLD_S = 4.0  # longer holds trip, if they do, within the three seconds of the held-stretch rule
_REHEARSED_REST_S = 4.0
_REHEARSED_DWELL_S = 0.5
_NEAR_LIMIT_SHARE = 0.85
_PATIENT_MOVES = ("transparent", "resistive")


def simulated_rig(plan: Plan) -> Rig:
    """The plan's twin in the simulation of its device, on simulated time."""
    robot, patient = simulated(plan.device, plan.twin, plan.seed)
    clock = SimulatedClock(robot.capabilities.period_ns, robot.advance)
    return Rig(robot, clock, patient)


def rehearse(plan: Plan) -> Certificate:
    """Check the plan as it stands, run it on the plan's twin, and certify the outcome.

    A real device is rehearsed on the simulation that stands for it, a hand that is not worn on its own.

    Returns:
        The certificate; where ``accepted`` is false, its summary names the first violation.

    Raises:
        Refused: The plan cannot be run at all: unknown mode, device or patient, other joints, unstable gains,
            limits that are expired, of another wrist angle or too wide.
    """
    dry = _dry(plan)
    rig = simulated_rig(dry)
    capabilities = rig.robot.capabilities
    joints = len(plan.joint_names)
    admit_limits(plan.limits, capabilities, plan.wrist_rad, time.time_ns())
    violation = _first_violation(plan, capabilities)
    if violation:
        return _certify(plan, False, violation, (0.0,) * joints, 0.0)
    observer = Observer(plan.joint_names)
    end = perform(dry, rig, Surroundings(observer, observer.sink, ScriptedInbox()))
    peaks = tuple(observer.peak_interaction_nm.tolist())
    if observer.first is not None:
        return _certify(plan, False, observer.first, peaks, end.simulated_s)
    if not end.completed:
        why = f"the dry run ended in {end.state.name}" + (f" ({end.reason})" if end.reason else "")
        return _certify(plan, False, why, peaks, end.simulated_s)
    return _certify(plan, True, _found(plan, observer, end), peaks, end.simulated_s)


def _first_violation(plan: Plan, capabilities: Capabilities) -> str:
    """What forbids the plan before any dry run, empty if nothing does."""
    if plan.path is not None:
        hand = patient_hand(plan.twin) if capabilities.chain == "hand" else None
        period_s = capabilities.period_ns * 1e-9
        found = check_path(QuinticPath(plan.path), plan.limits, plan.prescription.speed, period_s, hand)
        if found is not None:
            return found.sentence()
    moves = plan.prescription.mode in _PATIENT_MOVES if plan.sweep is None else plan.sweep.active
    return first_driven(plan, capabilities) if moves else ""


def _dry(plan: Plan) -> Plan:
    """The plan as it is rehearsed: simulated time, few repetitions over the whole range, no scripted stop.

    A fit check is rehearsed on a hand that fits: whether it does is what the check itself is for.
    """
    ordered = plan.prescription
    short = replace(
        ordered,
        repetitions=min(ordered.repetitions, REHEARSED_REPETITIONS),
        hold_s=min(ordered.hold_s, _REHEARSED_HOLD_S),
        rest_s=min(ordered.rest_s, _REHEARSED_REST_S),
        warm_up_repetitions=0,
        skin_check_s=0.0,
    )
    sweep, twin = plan.sweep, plan.twin
    if sweep is not None:
        sweep = replace(sweep, dwell_s=min(sweep.dwell_s, _REHEARSED_DWELL_S))
        if sweep.kind == "tone":
            sweep = _each_speed_once(sweep)
        if sweep.kind == "fit":
            twin = replace(twin, axis_offset_m=(0.0, 0.0), strap_slip_rad=0.0)
    return replace(plan, prescription=short, sweep=sweep, twin=twin, realtime=False, stop_at_s=())


def _each_speed_once(sweep: Sweep) -> Sweep:
    """A tone test with one stretch of each speed."""
    first = [sweep.stretch_rad_s.index(speed) for speed in dict.fromkeys(sweep.stretch_rad_s)]
    return replace(
        sweep,
        postures=tuple(sweep.postures[index] for index in first),
        goals_rad=sweep.goals_rad[first],
        stretch_rad_s=tuple(sweep.stretch_rad_s[index] for index in first),
    )


def _found(plan: Plan, observer: Observer, end: RunEnd) -> str:
    """What an accepted rehearsal tells the therapist, in one sentence."""
    share = observer.peak_interaction_nm / plan.limits.tau_interaction_nm
    joint = int(np.argmax(share))
    load = (
        f"highest load {observer.peak_interaction_nm[joint]:.2f} Nm at {plan.joint_names[joint]}, "
        f"limit {plan.limits.tau_interaction_nm[joint]:.2f} Nm"
    )
    if plan.sweep is not None:
        return f"within every bound: {load}, about {end.simulated_s:.0f} s"
    error = math.degrees(observer.rms_error_rad)
    if share[joint] > _NEAR_LIMIT_SHARE:
        return (
            f"within every bound, but the hand opens or closes only in part: {load}, mean error {error:.1f}°"
        )
    return f"within every bound: {load}, mean error {error:.1f}°"


def _certify(
    plan: Plan, accepted: bool, summary: str, peaks: tuple[float, ...], simulated_s: float
) -> Certificate:
    return seal(Certificate("", accepted, summary, peaks, simulated_s, plan_parts(plan)))
