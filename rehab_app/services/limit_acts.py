"""What a person may do to limits: look, set a torque or range. Safer is anyone's, more is a therapist's."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.clinical import Clinical
from rehab_app.services.diagnosis import Precautions, precautions
from rehab_app.services.order import check_wrist
from rehab_app.services.patient_limits import PatientLimits, TodaysLimits
from robot_iface.build import capabilities
from robot_iface.safety.shipped import THERAPIST_CAP_NM
from robot_iface.types import Capabilities
from sessions.catalogue import (
    RANGE_HIGH,
    RANGE_LOW,
    TORQUE_LIMIT,
    Catalogue,
    LimitChange,
    LimitsRead,
    Patient,
)

LEAST_NM = 0.02
"""Below this a joint cannot be moved at all."""
LEAST_RANGE_RAD = math.radians(5.0)
"""A narrower range is a typing error: no movement fits into it."""
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class _Case:
    """A patient in a device, with what holds now."""

    patient: Patient
    device: Capabilities
    cautions: Precautions
    today: TodaysLimits
    read: LimitsRead

    def column(self, joint: str) -> int:
        if joint not in self.device.joint_names:
            known = ", ".join(self.device.joint_names)
            raise Refused("joint", repr(joint[:40]), f"one of {known}", "choose one of these")
        return self.device.joint_names.index(joint)

    def change(self, actor: Account, joint: str, limit: str, value: float, reason: str) -> LimitChange:
        return LimitChange(
            patient=self.patient.id,
            device=self.device.name,
            joint=joint,
            limit=limit,
            value=value,
            reason=reason.strip(),
            by=actor.name,
        )

    @property
    def cap_nm(self) -> float:
        """To what a therapist may raise a torque limit: half where the clinical record halves them."""
        return THERAPIST_CAP_NM * (0.5 if self.cautions.halved else 1.0)


class LimitActs:
    """Acts on the limits of patients.

    Args:
        catalogue: The clinic's catalogue.
        clinical: Clinical records.
        limits: Where limits are kept.
    """

    def __init__(self, catalogue: Catalogue, clinical: Clinical, limits: PatientLimits) -> None:
        self._catalogue = catalogue
        self._clinical = clinical
        self._limits = limits

    def show(self, patient_id: str, device: str = "exoskeleton", wrist_rad: float = 0.0) -> TodaysLimits:
        """The limits that hold for a patient in a device now.

        Raises:
            Refused: Patient or device is unknown, or what was measured does not hold any more.
        """
        return self._case(patient_id, device, wrist_rad).today

    def set_torque(
        self,
        actor: Account,
        patient_id: str,
        joint: str,
        tau_nm: float,
        *,
        reason: str = "",
        device: str = "exoskeleton",
        wrist_rad: float = 0.0,
        since: int | None = None,
    ) -> TodaysLimits:
        """Set how much torque a joint may meet. More than ships holds for today, less until set anew.

        ``since`` is the version of the limits that the person had read, None if it does not matter.

        Raises:
            Refused: It is raised by somebody who may not prescribe, above 0.45 Nm (half of it where the
                record halves torques), or without a reason; patient, device or joint is unknown; or somebody
                else changed the limits since.
        """
        case = self._case(patient_id, device, wrist_rad, since)
        column = case.column(joint)
        if not LEAST_NM <= tau_nm <= case.cap_nm + _ROUNDING:
            halved = " (halved by the clinical record)" if case.cautions.halved else ""
            bound = f"{LEAST_NM:g} to {case.cap_nm:g} Nm{halved}"
            raise Refused(f"torque limit of {joint}", f"{tau_nm:g} Nm", bound, "choose within it")
        raised = tau_nm > float(case.today.limits.tau_interaction_nm[column]) + _ROUNDING
        if raised:
            self._may_raise(actor, reason, f"torque limit of {joint}")
        beyond = tau_nm > float(case.today.base.tau_interaction_nm[column]) + _ROUNDING
        set_to = case.change(actor, joint, TORQUE_LIMIT, tau_nm, reason)
        self._limits.add_changes(actor, (set_to,), case.read, for_today=beyond)
        return self._case(patient_id, device, wrist_rad).today

    def set_range(
        self,
        actor: Account,
        patient_id: str,
        joint: str,
        low_rad: float,
        high_rad: float,
        *,
        reason: str = "",
        device: str = "exoskeleton",
        wrist_rad: float = 0.0,
        since: int | None = None,
    ) -> TodaysLimits:
        """Set a joint's range within what was measured, or what ships. It holds until it is set anew.

        ``since`` is as of ``set_torque``.

        Raises:
            Refused: It is widened by somebody who may not prescribe or without a reason, reaches beyond what
                was measured, or is narrower than 5 degrees; patient, device or joint is unknown; or somebody
                else changed the limits since.
        """
        case = self._case(patient_id, device, wrist_rad, since)
        column = case.column(joint)
        lowest, highest = _ends(case.today.base.q_min_rad[column], case.today.base.q_max_rad[column])
        within = lowest - _ROUNDING <= low_rad and high_rad <= highest + _ROUNDING
        if not (within and high_rad - low_rad >= LEAST_RANGE_RAD - _ROUNDING):
            span = f"{math.degrees(low_rad):.4g} to {math.degrees(high_rad):.4g} degrees"
            least = f"{math.degrees(LEAST_RANGE_RAD):.0f} degrees or wider"
            bound = f"{least}, within {math.degrees(lowest):.0f} to {math.degrees(highest):.0f}"
            raise Refused(f"range of {joint}", span, bound, "choose within it, or measure the range again")
        low, high = _ends(case.today.limits.q_min_rad[column], case.today.limits.q_max_rad[column])
        if low_rad < low - _ROUNDING or high_rad > high + _ROUNDING:
            self._may_raise(actor, reason, f"range of {joint}")
        ends = ((RANGE_LOW, low_rad), (RANGE_HIGH, high_rad))
        set_to = tuple(case.change(actor, joint, limit, value, reason) for limit, value in ends)
        self._limits.add_changes(actor, set_to, case.read, for_today=False)
        return self._case(patient_id, device, wrist_rad).today

    def _case(self, patient_id: str, device: str, wrist_rad: float, since: int | None = None) -> _Case:
        patient = self._catalogue.patient(patient_id)
        check_wrist(wrist_rad)
        known = capabilities(device)
        record = self._clinical.record(patient_id)
        cautions = precautions(record)
        if not known.worn:
            raise Refused(
                f"limits of {patient_id}", f"asked for in {device}", "in a worn device", "choose one"
            )
        today = self._limits.today(patient, known, wrist_rad, cautions)
        change = today.version if since is None else since
        read = LimitsRead(change=change, record=0 if record is None else record.id)
        return _Case(patient, known, cautions, today, read)

    def _may_raise(self, actor: Account, reason: str, thing: str) -> None:
        require(actor, "prescribe")
        if not reason.strip():
            raise Refused(f"reason to raise the {thing}", "empty", "a sentence", "say why")


def _ends(low: float, high: float) -> tuple[float, float]:
    return float(low), float(high)
