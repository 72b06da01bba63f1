"""Turns an approved take and an order into a plan for one patient's hand on one robot."""

from __future__ import annotations

import json
import math

from rehab_app.recording.take import HandMotion
from rehab_app.services.order import Order
from rehab_app.services.rows import PreparedPlan, TakeRow
from rehab_app.services.wearer import Wearer, Wearers, binding
from rehab_app.therapy.reference import build_reference
from robot_iface.build import capabilities
from robot_iface.types import DIGITS, Plan
from sessions.catalogue import Catalogue, Patient

_LEAST, _MOST = 0.1, 4.0


class Planner:
    """Makes plans.

    Args:
        catalogue: Where the assistance of past sessions is remembered.
        wearers: What a plan must respect of a patient.
    """

    def __init__(self, catalogue: Catalogue, wearers: Wearers) -> None:
        self._catalogue = catalogue
        self._wearers = wearers

    def prepare(
        self, row: TakeRow, motion: HandMotion, patient: Patient | None, order: Order, version: str
    ) -> PreparedPlan:
        """Fit the take to the patient and state everything that the motion process needs.

        Args:
            row: The take.
            motion: Its movement.
            patient: The patient, None for an average hand of the take's side.
            order: What is asked for.
            version: Software version, which the certificate covers.

        Raises:
            Refused: A word or number of the order is out of bounds, the patient's record or limits forbid
                it, or the take is too fast for the limits.
        """
        device = capabilities(order.device)
        mode = order.named_mode()
        asked = order.prescription()  # refused before anything is read or fitted
        wearer = self._wearers.wearer(patient, row.side, device, order, (mode,))
        assistance, remembered = self._remembered(wearer, row, order)
        asked = order.prescription(assistance, wearer.skin_check_s)
        built = build_reference(
            motion,
            patient_geometry=wearer.geometry,
            patient_side=wearer.geometry.side,
            driven_joints=device.joint_names,
            limits=wearer.limits,
            take_digest=row.sha256,
            speed=asked.speed,
            device=device,
        )
        plan = Plan(
            device=order.device,
            path=built.path,
            prescription=asked,
            limits=wearer.limits,
            twin=wearer.twin,
            seed=order.seed,
            software_version=version,
            realtime=order.realtime,
            wrist_rad=order.wrist_rad,
            confirmed_device=order.confirmed_device,
        )
        return PreparedPlan(
            plan=plan,
            budget_m=built.residual_m,
            notes=(*_mirrored(row, wearer), *wearer.notes, *remembered, *built.notes),
            geometry=wearer.geometry,
            patient_id=wearer.patient_id,
            take_id=row.id,
            exercise=row.exercise,
            identity=wearer.identity,
            binding=binding(wearer.patient_id, plan),
        )

    def _remembered(
        self, wearer: Wearer, row: TakeRow, order: Order
    ) -> tuple[tuple[tuple[float, ...], ...], tuple[str, ...]]:
        """Assistance of the last session of this exercise, unless another stiffness is asked for."""
        if not wearer.patient_id or order.mode != "assistive" or order.stiffness_multiple is not None:
            return (), ()
        found = self._catalogue.assistance(wearer.patient_id, row.exercise, order.device)
        rows = () if found is None else assistance_from_json(found.content)
        if not rows or found is None:
            return (), ()
        note = f"Assistance begins where session {found.session} of this exercise ended."
        return rows, (note,)


def assistance_to_json(rows: tuple[tuple[float, ...], ...]) -> str:
    """Assistance as the catalogue keeps it."""
    return json.dumps([list(row) for row in rows])


def assistance_from_json(text: str) -> tuple[tuple[float, ...], ...]:
    """Assistance within its bounds, 2 x 5; empty where the text holds none."""
    try:
        rows = tuple(tuple(float(value) for value in row) for row in json.loads(text))
    except (TypeError, ValueError):
        return ()
    whole = len(rows) == 2 and all(len(row) == len(DIGITS) for row in rows)
    if not whole or not all(math.isfinite(value) for row in rows for value in row):
        return ()
    return tuple(tuple(min(max(value, _LEAST), _MOST) for value in row) for row in rows)


def _mirrored(row: TakeRow, wearer: Wearer) -> tuple[str, ...]:
    side = wearer.geometry.side
    return () if side == row.side else (f"The take of a {row.side} hand is mirrored for a {side} hand.",)
