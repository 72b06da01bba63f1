"""Rehearses a plan before anything moves: a static check of the whole path, then a dry run on the twin.

What is refused: a path that leaves the range or the speed limits anywhere (also between its knots), and a
dry run in which the supervisor had to hold, yield or stop, or that did not come to its end. What is not
refused: a stiff hand that the permitted torque opens only in part. The control law's spring saturates below
the interaction limit, so such a session runs, opens as far as the limit lets it, and the certificate says how
near to the limit it came; only load beyond the limit trips.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robot_iface.errors import Refused
from robot_iface.loop import SimulatedClock
from robot_iface.motion import QuinticPath, check_path
from robot_iface.rehearsal.observe import Observer
from robot_iface.runtime import Rig, ScriptedInbox, Surroundings, perform, plan_parts, seal
from robot_iface.sim import SimulatedExoskeleton
from robot_iface.types import Certificate, Plan

REHEARSED_REPETITIONS = 2
"""Repetitions of the dry run: the second already carries what the first has taught."""
_REHEARSED_HOLD_S = 4.0  # longer holds trip, if they do, within the three seconds of the held-stretch rule
_REHEARSED_REST_S = 4.0
_NEAR_LIMIT_SHARE = 0.85


def simulated_rig(plan: Plan) -> Rig:
    """The plan's twin in the simulated exoskeleton, on simulated time."""
    robot = SimulatedExoskeleton(plan.twin, plan.seed)
    clock = SimulatedClock(robot.capabilities.period_ns, robot.advance)
    return Rig(robot, clock, robot.patient)


def rehearse(plan: Plan) -> Certificate:
    """Check the plan's whole path, run it on the plan's twin, and certify the outcome.

    Returns:
        The certificate; where ``accepted`` is false, its summary names the first violation.

    Raises:
        Refused: The plan cannot be run at all: unknown mode or patient, a path for other joints, bad limits.
    """
    rig = simulated_rig(plan)
    joints = len(plan.joint_names)
    if plan.path is None:
        raise Refused("rehearsal", "of a plan without a path", "of a path", "plan a take")
    violation = check_path(
        QuinticPath(plan.path), plan.limits, plan.prescription.speed, rig.robot.capabilities.period_ns * 1e-9
    )
    if violation is not None:
        return _certify(plan, False, violation.sentence(), (0.0,) * joints, 0.0)
    observer = Observer(plan.joint_names)
    end = perform(_dry(plan), rig, Surroundings(observer, observer.sink, ScriptedInbox()))
    peaks = tuple(observer.peak_interaction_nm.tolist())
    if observer.first is not None:
        return _certify(plan, False, observer.first, peaks, end.simulated_s)
    if not end.completed:
        return _certify(plan, False, f"the dry run ended in {end.state.name}", peaks, end.simulated_s)
    return _certify(plan, True, _found(plan, observer), peaks, end.simulated_s)


def _dry(plan: Plan) -> Plan:
    """The plan as it is rehearsed: on simulated time, few repetitions, no scripted stop."""
    ordered = plan.prescription
    short = replace(
        ordered,
        repetitions=min(ordered.repetitions, REHEARSED_REPETITIONS),
        hold_s=min(ordered.hold_s, _REHEARSED_HOLD_S),
        rest_s=min(ordered.rest_s, _REHEARSED_REST_S),
    )
    return replace(plan, prescription=short, realtime=False, stop_at_s=())


def _found(plan: Plan, observer: Observer) -> str:
    """What an accepted rehearsal tells the therapist, in one sentence."""
    share = observer.peak_interaction_nm / plan.limits.tau_interaction_nm
    joint = int(np.argmax(share))
    load = (
        f"highest load {observer.peak_interaction_nm[joint]:.2f} Nm at {plan.joint_names[joint]}, "
        f"limit {plan.limits.tau_interaction_nm[joint]:.2f} Nm"
    )
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
