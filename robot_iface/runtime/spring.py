"""Stiffness that rises and falls without pulling the hand or letting it go."""

from __future__ import annotations

import numpy as np

from robot_iface.control import thesis_gains
from robot_iface.control.impedance import SPRING_SHARE
from robot_iface.types import Float64, Plan

TORQUE_SLEW_NM_S = 0.15
"""Moves a hand of 0.64 Nm/rad (Ashworth 3) at 13 deg/s, below the shipped 15."""


class Spring:
    """The present stiffness as a multiple of the thesis gains.

    A stiff hand stands far from where it should be. Raising stiffness there pulls it, and lowering it lets it
    go, at a speed that no limit of the path bounds. So the torque of the spring changes slowly, unless the
    spring is saturated and its torque does not depend on its stiffness.

    Args:
        plan: Prescribed multiple and ramp, and the limits.
        first: First multiple, at most the prescribed one.
        period_s: Control period.
    """

    def __init__(self, plan: Plan, first: float, period_s: float) -> None:
        ordered, names = plan.prescription, plan.joint_names
        self._thesis_nm_rad = thesis_gains(names).stiffness_nm_rad
        self._slew = max(ordered.stiffness_multiple, 1.0) / ordered.ramp_s * period_s
        self._gentle_nm = TORQUE_SLEW_NM_S * period_s
        self._saturation_nm = SPRING_SHARE * plan.limits.tau_interaction_nm
        self.multiple: Float64 = np.full(len(names), min(first, ordered.stiffness_multiple))
        """Multiple of the thesis gains, (J,)."""

    @property
    def stiffness_nm_rad(self) -> Float64:
        """Present stiffness, (J,)."""
        return self._thesis_nm_rad * self.multiple

    def soften(self, multiple: float) -> None:
        """Be no stiffer than this from now on; only where the spring is about to begin anew from rest."""
        self.multiple = np.minimum(self.multiple, multiple)

    def change(self, wanted: Float64, gap_rad: Float64) -> None:
        """Go one tick towards a multiple, (J,), with the joints ``gap_rad``, (J,), from their set-point."""
        per_multiple = self._thesis_nm_rad * gap_rad
        gentle = np.minimum(self._gentle_nm / (per_multiple + 1e-9), self._slew)
        slew = np.where(self.multiple * per_multiple > self._saturation_nm, self._slew, gentle)
        self.multiple = self.multiple + np.minimum(np.maximum(wanted - self.multiple, -slew), slew)
