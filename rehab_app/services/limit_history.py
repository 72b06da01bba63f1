"""What was measured and set on a patient's joints in a worn device, for a page that shows it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from rehab_app.errors import REFUSALS
from rehab_app.services.limit_acts import LimitActs
from rehab_app.services.patient_limits import TodaysLimits
from robot_iface.build import capabilities
from sessions.catalogue import Catalogue, DayLimits, LimitChange

DEVICE = "exoskeleton"


@dataclass(frozen=True, slots=True)
class LimitView:
    """Limits of a patient today, and how they came about.

    Attributes:
        today: What holds now; None where nothing does, because what was measured has expired.
        why_not: The sentence for that, else empty.
        joints: Names of the driven joints, in the order of the limits.
        wrist_rad: Wrist extension for which they are shown.
        measured: Everything that was measured, newest first.
        changed: Every limit that a person set, newest first.
        now_ns: When this was looked up, UTC in ns.
    """

    today: TodaysLimits | None
    why_not: str
    joints: tuple[str, ...]
    wrist_rad: float
    measured: tuple[DayLimits, ...]
    changed: tuple[LimitChange, ...]
    now_ns: int

    @property
    def newest(self) -> DayLimits | None:
        """The newest measurement, None where nothing was measured."""
        return next(iter(self.measured), None)


class LimitHistory:
    """Looks limits up.

    Args:
        catalogue: The clinic's catalogue.
        limits: The limits that hold today.
        clock_ns: UTC in ns.
    """

    def __init__(
        self, catalogue: Catalogue, limits: LimitActs, clock_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._catalogue = catalogue
        self._limits = limits
        self._clock_ns = clock_ns

    def show(self, patient_id: str, device: str = DEVICE) -> LimitView:
        """Limits at the wrist angle of the newest measurement, and their history.

        Raises:
            Refused: The patient or device is unknown.
        """
        measured = self._catalogue.day_limits(patient_id, device)
        changed = self._catalogue.limit_changes(patient_id, device)
        wrist_rad = measured[0].wrist_rad if measured else 0.0
        today, why_not = None, ""
        try:
            today = self._limits.show(patient_id, device, wrist_rad)
        except REFUSALS as refusal:
            why_not = str(refusal)
        joints = capabilities(device).joint_names
        return LimitView(today, why_not, joints, wrist_rad, measured, changed, self._clock_ns())
