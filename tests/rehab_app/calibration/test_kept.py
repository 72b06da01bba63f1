"""Calibrations of cameras and hands as the clinic keeps them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.access import Account
from rehab_app.bootstrap import open_clinic
from rehab_app.calibration import CalibratedCamera
from rehab_app.errors import Refused
from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.subject import average_subject
from rehab_app.vision import colour_to_json, named_colour

ASSISTANT = Account("tom", "assistant", "1")
AUDITOR = Account("eve", "auditor", "2")


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        yield opened


def test_versions_of_a_camera(clinic, scene):
    first = CalibratedCamera(
        camera="webcam:0", intrinsics=scene.intrinsics, lens=scene.lens, verdict="usable"
    )
    assert clinic.calibrations.current("webcam:0") is None
    row = clinic.calibrations.add(ASSISTANT, first)
    kept = clinic.calibrations.current("webcam:0")
    assert kept.created_utc
    assert kept.digest == row.digest
    assert replace(kept, created_utc="") == first or kept.table() | {"created_utc": ""} == first.table()
    better = replace(first, verdict="good", colour=colour_to_json(named_colour("green"))).now()
    assert clinic.calibrations.add(ASSISTANT, better).digest == better.digest
    assert clinic.calibrations.current("webcam:0").table() == better.table()
    assert clinic.calibrations.get(row.digest[:10]).table() == kept.table()
    assert [one.verdict for one in clinic.calibrations.list("webcam:0")] == ["good", "usable"]
    with pytest.raises(Refused, match="unknown"):
        clinic.calibrations.get("0" * 64)
    with pytest.raises(Refused, match="may not record"):
        clinic.calibrations.add(AUDITOR, first)


def test_hands_of_persons(clinic):
    protocol = load_protocol("thesis25")
    small, large = (average_subject(protocol, "right", length) for length in (0.17, 0.2))
    assert clinic.hands.current("P-0001", "right", "thesis25") is None
    clinic.hands.keep(ASSISTANT, "P-0001", "thesis25", small)
    clinic.hands.keep(ASSISTANT, "P-0001", "thesis25", large)
    clinic.hands.keep(ASSISTANT, "T-1", "thesis25", small)
    kept = clinic.hands.current("P-0001", "right", "thesis25")
    assert np.array_equal(kept.geometry.bones_m, large.geometry.bones_m)
    assert kept.marker_names == large.marker_names
    assert clinic.hands.current("P-0001", "left", "thesis25") is None
    assert clinic.hands.current("P-0001", "right", "fingertips5") is None
    assert len(clinic.hands.list("P-0001")) == 2
    with pytest.raises(Refused, match="may not record"):
        clinic.hands.keep(AUDITOR, "P-0001", "thesis25", small)
    verbs = [row.verb for row in clinic.catalogue.audit()]
    assert verbs.count("keep hand") == 3
