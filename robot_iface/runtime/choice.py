"""The only place that chooses what a run is busy with."""

from __future__ import annotations

from robot_iface.runtime.exercise import Exercise
from robot_iface.runtime.orders import Patient
from robot_iface.runtime.sweep import GuidedSweep
from robot_iface.runtime.sweep_fit import FitCheck
from robot_iface.runtime.sweep_tone import ToneTest
from robot_iface.runtime.task import Task
from robot_iface.types import Plan


def make_task(plan: Plan, patient: Patient, period_s: float) -> Task:
    """The exercise of a plan with a path; the guided assessment of a plan without one.

    Raises:
        Refused: The plan cannot be played.
    """
    if plan.sweep is not None and plan.sweep.kind == "fit":
        return FitCheck(plan, period_s)
    if plan.sweep is not None and plan.sweep.kind == "tone":
        return ToneTest(plan, period_s)
    if plan.sweep is not None:
        return GuidedSweep(plan, patient, period_s)
    return Exercise(plan, patient, period_s)
