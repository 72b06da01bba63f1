"""Hazard 9: skin that does not feel. Halved limits are what the device then really applies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rehab_app.services.diagnosis import precautions
from robot_iface.safety import shipped_limits
from sessions.catalogue import ClinicalRecord


def test_a_stiff_hand_is_loaded_with_half(rigid: Any) -> None:
    low, high = np.zeros(3), np.full(3, 1.6)
    peaks = []
    for halved in (False, True):
        limits = shipped_limits(rigid.NAMES, low, high, halved=halved)
        rig = rigid.Rig(multiple=10.0, ramp_s=0.05, limits=limits, q_rad=1.2, stiffness=0.6, rest_rad=1.2)
        rig.go_active()
        rig.glide(np.deg2rad(-15.0), 3.0)
        peaks.append(np.abs([state.tau_interaction_nm for state in rig.states]).max(axis=0))
        assert rig.events() == []
    assert np.allclose(peaks[1], 0.5 * peaks[0], rtol=0.05)
    assert np.all(peaks[0] <= [0.25, 0.15, 0.10])


@pytest.mark.parametrize(
    ("stated", "halved", "skin_check_s"),
    [
        ({}, False, 0.0),
        ({"insensate": True}, True, 600.0),
        ({"unaware": True}, False, 600.0),
        ({"rheumatoid": True}, True, 0.0),
        ({"crps": True}, True, 0.0),
        ({"diagnosis": "nerve-lesion"}, True, 600.0),
        ({"diagnosis": "burn"}, True, 600.0),
    ],
)
def test_who_does_not_feel_or_cannot_say_is_looked_at(
    stated: dict[str, Any], halved: bool, skin_check_s: float
) -> None:
    """Neglect and aphasia do not halve: they keep a patient from saying that it hurts."""
    record = ClinicalRecord(**{"patient": "P-0001", "diagnosis": "none", "by": "anna", **stated})
    follows = precautions(record)
    assert (follows.halved, follows.skin_check_s) == (halved, skin_check_s)
