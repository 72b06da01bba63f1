"""Assessments from plan to kept result: what a weak, a spastic and a short hand show."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services import sweep_postures
from rehab_app.services.order import Order
from rehab_app.services.protocol_results import ranges_of
from robot_iface.motion.limits import SweepResult

MCP = "index_mcp_flexion"


@pytest.fixture(scope="module")
def clinic(tmp_path_factory, take_file):
    with open_clinic(tmp_path_factory.mktemp("clinic")) as opened:
        for name in ("A", "B"):
            opened.patients.add(
                CONSOLE, given_name="Ada", family_name=name, birth_date="1950-01-01", side="right"
            )
        take = opened.takes.get(take_file)
        opened.takes.approve(take.id, CONSOLE)
        yield opened


def named(rows, joint=MCP):
    return next(row for row in rows if row.joint == joint)


def test_a_weak_hand_lags_behind_what_it_is_led_to(clinic):
    kept = clinic.protocols.range(CONSOLE, "P-0002", Order(twin="weak"))
    assert named(kept.result.ranges).extension_lag_rad > math.radians(5.0)
    assert named(kept.result.ranges).extension_deficit_rad < math.radians(5.0)
    assert any("device limit" in note for note in kept.result.notes)
    assert clinic.protocols.history("P-0002", "range") == (kept,)
    assert clinic.protocols.history("P-0002", "tone") == ()
    assert kept.by == "console"
    assert clinic.catalogue.session(kept.result.session).patient == "P-0002"


def test_lag_is_weakness_and_deficit_is_shortness():
    """By hand: alone 20 to 60 degrees, led 10 to 80; the second joint broke off."""
    degrees = np.deg2rad([[20.0, np.nan], [60.0, np.nan]])
    led = np.deg2rad([[10.0, 5.0], [80.0, np.nan]])
    ends = np.array([[False, False], [True, False]])
    found = SweepResult(
        ("index_mcp_flexion", "index_pip"),
        "right",
        ("open", "fist"),
        np.zeros(2),
        degrees,
        led,
        led,
        ~ends,
        ends,
    )
    first, second = ranges_of(found)
    assert first.extension_lag_rad == pytest.approx(math.radians(10.0))
    assert first.extension_deficit_rad == pytest.approx(math.radians(10.0))
    assert first.flexion_lag_rad == pytest.approx(math.radians(20.0))
    assert (first.min_at_device_end, first.max_at_device_end) == (False, True)
    assert (second.active_min_rad, second.extension_lag_rad) == (None, None)
    assert second.passive_min_rad == second.passive_max_rad == pytest.approx(math.radians(5.0))


def test_tone_is_kept_with_the_arms_posture_and_never_as_a_grade(clinic, monkeypatch):
    monkeypatch.setattr(sweep_postures, "TONE_REPEATS", 2)
    kept = clinic.protocols.tone(CONSOLE, "P-0001", "seated, elbow at 90 degrees", Order(twin="mas2"))
    result = kept.result
    assert result.arm_posture == "seated, elbow at 90 degrees"
    assert result.asked_rad_s == pytest.approx([math.radians(v) for v in (10, 10, 45, 45, 90, 90)])
    assert named(result.tones).per_speed_nms_rad is not None
    assert {tone.joint.split("_")[0] for tone in result.tones} == {"index", "middle", "ring", "little"}
    assert any("no Modified Ashworth grade" in note for note in result.notes)
    assert any("90 degrees/s was asked for and made" in note for note in result.notes)
    assert not any("MAS" in note for note in result.notes)


def test_tracking_is_without_help_and_taken_apart(clinic):
    take = clinic.takes.list()[0].id
    result = clinic.protocols.tracking(CONSOLE, "P-0001", take, Order(repetitions=2)).result
    whole = {row.name: row for row in result.tracked if row.subject == "whole"}
    assert whole["fingertip_rmse"].value > 0.0
    assert {row.name for row in result.tracked} >= {"timing_delay", "shape_error", "offset_error"}
    assert clinic.catalogue.session(result.session).mode == "transparent"


def test_what_cannot_be_assessed_is_a_sentence(clinic):
    protocols = clinic.protocols
    with pytest.raises(Refused, match="arm posture"):
        protocols.tone(CONSOLE, "P-0001", "  ")
    with pytest.raises(Refused, match="P-0009"):
        protocols.range(CONSOLE, "P-0009")
    with pytest.raises(Refused, match="may not play"):
        protocols.range(Account("a", "auditor", "1"), "P-0001")
    with pytest.raises(Refused, match="not worn"):
        protocols.tone(CONSOLE, "P-0001", "seated", Order(device="dlr-hit-ii"))
