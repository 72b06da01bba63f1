"""Limits of a patient in a device today: measured, else shipped; then what a person set on single joints."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.clock import day_end_ns, day_start_ns
from rehab_app.services.diagnosis import Precautions
from rehab_app.services.limits_json import limits_from_json, limits_to_json
from robot_iface.safety import shipped_limits
from robot_iface.safety.admission import WRIST_RAD
from robot_iface.types import Capabilities, Limits
from sessions.catalogue import (
    RANGE_HIGH,
    RANGE_LOW,
    TORQUE_LIMIT,
    Catalogue,
    DayLimits,
    LimitChange,
    LimitsRead,
    Patient,
)


@dataclass(frozen=True, slots=True)
class TodaysLimits:
    """Limits that hold now and where they come from.

    Attributes:
        limits: The limits.
        base: The same before a person changed single joints.
        measured: Whether they were measured on the patient.
        own_range: Whether a person measured or set the range today.
        notes: Where they come from, as sentences.
        version: Number of the newest limit that a person set there, 0 where nobody did.
    """

    limits: Limits
    base: Limits
    measured: bool
    own_range: bool
    notes: tuple[str, ...]
    version: int = 0


class PatientLimits:
    """Reads and keeps limits.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where they are noted.
        clock_ns: UTC in ns.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, clock_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._clock_ns = clock_ns

    def shipped(self, device: Capabilities, cautions: Precautions, patient_id: str = "") -> TodaysLimits:
        """The limits that ship, for a hand of which nothing was measured; said so."""
        base = _shipped(device, cautions)
        notes = ("No limits were measured today: the shipped defaults hold.",)
        return self._changed(base, False, notes, patient_id, device, cautions)

    def today(
        self, patient: Patient, device: Capabilities, wrist_rad: float, cautions: Precautions
    ) -> TodaysLimits:
        """The limits that hold for a patient in a worn device now.

        What was measured narrows what ships for the patient's present precautions; it never widens it.

        Args:
            patient: The patient.
            device: The device.
            wrist_rad: Wrist extension at which the hand is held now.
            cautions: What follows from the clinical record.

        Raises:
            Refused: What was measured has expired, was measured at another wrist angle or on the other hand,
                or belongs to another set of joints.
        """
        rows = self._catalogue.day_limits(patient.id, device.name)
        if not rows:
            return self.shipped(device, cautions, patient.id)
        row = _matching(rows, self._clock_ns(), wrist_rad, patient)
        base = _narrowed(_shipped(device, cautions), limits_from_json(row.content), row)
        degrees = math.degrees(row.wrist_rad)
        notes = (f"Today's limits were measured by {row.by} with the wrist at {degrees:.0f} degrees.",)
        return self._changed(base, True, notes, patient.id, device, cautions)

    def keep(
        self, actor: Account, patient: Patient, device: Capabilities, limits: Limits, wrist_rad: float
    ) -> DayLimits:
        """Keep limits that were measured just now; they hold until the day ends.

        Raises:
            Refused: The wrist angle is no angle.
        """
        now_ns = self._clock_ns()
        dated = replace(
            limits, measured_utc_ns=now_ns, expires_utc_ns=day_end_ns(now_ns), wrist_rad=wrist_rad
        )
        kept = self._catalogue.add_day_limits(
            DayLimits(
                patient=patient.id,
                side=patient.side,
                device=device.name,
                wrist_rad=wrist_rad,
                content=limits_to_json(dated),
                measured_utc_ns=now_ns,
                expires_utc_ns=dated.expires_utc_ns,
                by=actor.name,
            )
        )
        self._audit.note(actor, "measure limits", patient.id, f"{device.name}, version {kept.id}")
        return kept

    def add_changes(
        self, actor: Account, changes: tuple[LimitChange, ...], since: LimitsRead, *, for_today: bool
    ) -> None:
        """Keep limits that a person set on a joint, for today only or until the next ones; all or none.

        Raises:
            Refused: Somebody else changed the limits, or what they follow from, since they were read.
        """
        expires = day_end_ns(self._clock_ns()) if for_today else 0
        dated = tuple(replace(one, expires_utc_ns=expires, by=actor.name) for one in changes)
        for kept in self._catalogue.add_limit_changes(dated, since):
            what = f"{kept.joint} {kept.limit} {kept.value:.4g}, version {kept.id}"
            self._audit.note(actor, "set limit", kept.patient, what)

    def _changed(
        self,
        base: Limits,
        measured: bool,
        notes: tuple[str, ...],
        patient_id: str,
        device: Capabilities,
        cautions: Precautions,
    ) -> TodaysLimits:
        """What a person set on single joints, on top of the base."""
        now_ns = self._clock_ns()
        rows = self._catalogue.limit_changes(patient_id, device.name) if patient_id else ()
        valid = [row for row in rows if not 0 < row.expires_utc_ns <= now_ns]
        newest: dict[tuple[str, str], LimitChange] = {}
        for row in valid:
            if row.joint in device.joint_names:
                newest.setdefault((row.joint, row.limit), row)
        version = rows[0].id if rows else 0
        limits = _with_changes(base, device.joint_names, newest.values(), cautions.stated_utc_ns)
        _check_open(limits, device.joint_names)
        today_ns = day_start_ns(now_ns)
        set_today = any(row.limit != TORQUE_LIMIT and row.created_utc_ns >= today_ns for row in valid)
        told = tuple(_words(row, cautions.stated_utc_ns) for row in newest.values())
        return TodaysLimits(limits, base, measured, measured or set_today, (*notes, *told), version)


def _shipped(device: Capabilities, cautions: Precautions) -> Limits:
    return shipped_limits(
        device.joint_names,
        device.q_min_rad,
        device.q_max_rad,
        spastic=cautions.spastic,
        halved=cautions.halved,
        hyperextension=cautions.hyperextension,
    )


def _matching(rows: tuple[DayLimits, ...], now_ns: int, wrist_rad: float, patient: Patient) -> DayLimits:
    """The newest limits that hold for this hand, now and at this wrist angle."""
    newest = rows[0]
    again = "measure them again with rehab-app limits measure"
    valid = [row for row in rows if now_ns < row.expires_utc_ns]
    if not valid:
        raise Refused(f"limits of {patient.id}", "expired", "measured today", again)
    same_side = [row for row in valid if row.side == patient.side]
    if not same_side:
        bound = f"of the {patient.side} hand"
        raise Refused(f"limits of {patient.id}", f"of the {newest.side} hand", bound, again)
    for row in same_side:
        if abs(row.wrist_rad - wrist_rad) <= WRIST_RAD:
            return row
    measured = math.degrees(same_side[0].wrist_rad)
    raise Refused(
        "wrist angle",
        f"{math.degrees(wrist_rad):.0f} degrees",
        f"{measured:.0f} degrees, at which the limits were measured",
        f"hold the wrist so and give that angle, or {again}",
    )


def _narrowed(shipped: Limits, measured: Limits, row: DayLimits) -> Limits:
    """What ships, narrowed to what was measured.

    Raises:
        Refused: The measurement is of other joints.
    """
    if measured.q_min_rad.shape != shipped.q_min_rad.shape:
        raise Refused(
            f"limits of {row.patient}",
            f"of {measured.q_min_rad.size} joints",
            f"of the {shipped.q_min_rad.size} of the device",
            "measure them again with rehab-app limits measure",
        )
    low = np.maximum(shipped.q_min_rad, measured.q_min_rad)
    high = np.minimum(shipped.q_max_rad, measured.q_max_rad)
    return replace(
        shipped,
        q_min_rad=low,
        q_max_rad=high,
        flexion_speed_rad_s=np.minimum(shipped.flexion_speed_rad_s, measured.flexion_speed_rad_s),
        extension_speed_rad_s=np.minimum(shipped.extension_speed_rad_s, measured.extension_speed_rad_s),
        tau_interaction_nm=np.minimum(shipped.tau_interaction_nm, measured.tau_interaction_nm),
        hulls=measured.hulls,
        measured_utc_ns=row.measured_utc_ns,
        expires_utc_ns=row.expires_utc_ns,
        wrist_rad=row.wrist_rad,
    )


def _with_changes(
    base: Limits, joint_names: tuple[str, ...], changes: Iterable[LimitChange], stated_utc_ns: int
) -> Limits:
    """The base with single limits set; what was raised before the record was stated is not raised."""
    low, high, torque = base.q_min_rad.copy(), base.q_max_rad.copy(), base.tau_interaction_nm.copy()
    for row in changes:
        joint = joint_names.index(row.joint)
        if row.limit == TORQUE_LIMIT:
            # neither what holds until further notice nor what is older than the record ever raises:
            # precautions may have become stricter since
            raises = row.expires_utc_ns and row.created_utc_ns >= stated_utc_ns
            torque[joint] = row.value if raises else min(torque[joint], row.value)
        elif row.limit == RANGE_LOW:
            low[joint] = max(low[joint], row.value)
        elif row.limit == RANGE_HIGH:
            high[joint] = min(high[joint], row.value)
    return replace(base, q_min_rad=low, q_max_rad=high, tau_interaction_nm=torque)


def _check_open(limits: Limits, joint_names: tuple[str, ...]) -> None:
    for name, low, high in zip(joint_names, limits.q_min_rad, limits.q_max_rad, strict=True):
        if not low < high:
            span = f"{math.degrees(low):.0f} to {math.degrees(high):.0f} degrees"
            remedy = "set it anew with rehab-app limits range"
            raise Refused(f"range of {name}", span, "a range that opens", remedy)


def _words(row: LimitChange, stated_utc_ns: int) -> str:
    if row.limit == TORQUE_LIMIT:
        words = f"Torque limit of {row.joint} was set to {row.value:.2f} Nm by {row.by}"
        before = row.expires_utc_ns and row.created_utc_ns < stated_utc_ns
        return (
            f"{words}, before the clinical record was stated: more is to be set anew."
            if before
            else f"{words}."
        )
    end = "lower" if row.limit == RANGE_LOW else "upper"
    return f"The {end} end of {row.joint} was set to {math.degrees(row.value):.0f} degrees by {row.by}."
