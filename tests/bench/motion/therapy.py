"""What a course of therapy reaches in simulation: learning, assistance, contracture, slacking, speed."""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Any

import mujoco as engine
import numpy as np

from robot_iface.build import open_rig
from robot_iface.kinematics import average_hand
from robot_iface.runtime import ScriptedInbox, Surroundings, perform
from robot_iface.sim import VirtualPatient, build_model, device_capabilities, virtual_patient
from robot_iface.types import Mode, Plan, VirtualKind
from tests.bench.motion.table import Row, at_least, at_most, beside
from tests.robot_iface.conftest import Course, NeverPressed, fist, make_plan

LEARNERS: tuple[VirtualKind, ...] = ("healthy", "weak", "flaccid")
REPETITIONS = 7
ASSISTED = 11
SLACKED = 8
NOISE_DEG = 0.011
"""What the encoders alone make of a tracking error: below it nothing need fall any further."""


def learning_row(kind: VirtualKind) -> Row:
    """Last over first tracking error of passive repetitions, and whether it fell until the sensors' noise."""
    run = Course(make_plan(kind, repetitions=REPETITIONS, path=fist(3.0, 20.0, 8.0)))
    errors = [run.rmse_deg(repetition) for repetition in range(REPETITIONS)]
    pairs = pairwise(errors)
    falls = all(later <= before or later <= 2.0 * NOISE_DEG for before, later in pairs)
    ratio = errors[-1] / errors[0]
    measured = f"{ratio:.3f} ({errors[0]:.2f} to {errors[-1]:.3f} deg{'' if falls else ', not monotone'})"
    what = f"passive learning, last / first of {REPETITIONS}, {kind}"
    return Row(what, "<= 0.2, monotone", "0.05", measured, falls and ratio <= 0.2)


def assist_row() -> Row:
    """Robot torque at high ability, adapting over not adapting, in the last repetition."""
    able = VirtualPatient(0.04, ability=0.76, will="follow")
    plan = make_plan("healthy", "assistive", repetitions=ASSISTED, path=fist(3.0, 22.0, 8.0))
    run = Course(plan, patient=able)
    adaptive = run.rms_interaction_nm(ASSISTED - 1)
    fixed = run.rms_interaction_nm(0)
    return at_most(
        f"assist: robot torque at ability .76, repetition {ASSISTED} / first", adaptive / fixed, 0.6, 0.4
    )


def contracture_row() -> Row:
    """Largest rise of any digit's stiffness from repetition to repetition against a virtual block."""
    plan = make_plan("contracture", "assistive", repetitions=5, path=fist(3.0, 40.0, 8.0), cue_timeout_s=2.0)
    run = Course(plan)
    multiples = [run.multiple(repetition) for repetition in range(5)]
    rise = float(np.diff(multiples).max())
    phrase = ", ".join(f"{multiple:.2f}" for multiple in multiples)
    return Row("contracture: K from repetition to repetition", "never rises", "", phrase, rise <= 1e-9)


def slacking_row() -> Row:
    """What a slacking patient still gives after assistive repetitions with forgetting and without."""
    forgetful, perfect = (_effort_left(forgetting) for forgetting in (0.8, 1.0))
    measured = f"{forgetful:.2f} with, {perfect:.2f} without"
    return Row("slacking: final effort with forgetting", "higher", "", measured, forgetful > perfect)


def _effort_left(forgetting: float) -> float:
    """The robot's spring is soft here, so that it is the learnt torque that helps."""
    plan = make_plan(
        "slacking",
        "assistive",
        multiple=0.5,
        repetitions=SLACKED,
        path=fist(3.0, 35.0, 25.0),
        speed=1.0,
        assist_forgetting=forgetting,
    )
    return Course(plan).robot.patient.willingness


def speed_rows(mode: Mode) -> list[Row]:
    """A minute of therapy, recording and digest included, beside real time and a bare ``mj_step``."""
    plan = make_plan("weak", mode, repetitions=6, path=fist(4.0, 30.0, 10.0), rest_s=1.0, hold_s=0.5)
    best_us, ratio = np.inf, 0.0
    for _ in range(3):
        begun = time.process_time()
        end = perform(
            plan, open_rig(plan), Surroundings(NeverPressed(), lambda message: None, ScriptedInbox())
        )
        spent_s = time.process_time() - begun
        best_us, ratio = min(best_us, spent_s / end.simulated_s * 1e3), max(ratio, end.simulated_s / spent_s)
    bare_us = bare_step_us(plan)
    return [
        at_least(f"{mode} therapy against real time, one core, contacts on", ratio, 5.0, 15.0, " x"),
        beside(f"one {mode} tick beside direct mj_step", f"{best_us:.0f} us beside {bare_us:.0f} us"),
    ]


def bare_step_us(plan: Plan) -> float:
    """The engine alone on the same model."""
    device = device_capabilities()
    hand = build_model(average_hand(), virtual_patient(plan.twin.kind), device.q_min_rad, device.q_max_rad)
    mujoco: Any = engine
    state = mujoco.MjData(hand.model)
    begun = time.process_time()
    for _ in range(20_000):
        mujoco.mj_step(hand.model, state)
    return (time.process_time() - begun) / 20_000 * 1e6


def therapy_rows() -> list[Row]:
    """All of them."""
    rows = [learning_row(kind) for kind in LEARNERS]
    rows += [assist_row(), contracture_row(), slacking_row()]
    return rows + speed_rows("passive") + speed_rows("assistive")
