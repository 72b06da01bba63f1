"""What a clinical record means for therapy. The matrix of template, mode and date is a test of hazard 10."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest

from rehab_app.errors import Refused
from rehab_app.services.diagnosis import locks_of, needs_own_range, precautions, template, templates_of
from rehab_app.services.diagnosis_templates import BY_ACT_ONLY, KEYS, TEMPLATES
from robot_iface.types import MODES
from sessions.catalogue import ClinicalRecord

TODAY = date(2026, 6, 1)
PAGE = Path(__file__).resolve().parents[3] / "docs" / "precautions.md"


def record(diagnosis="none", **changes):
    return replace(
        ClinicalRecord(patient="P-0001", diagnosis=diagnosis, event_date="2026-01-01", by="anna"), **changes
    )


def test_no_record_asks_for_no_precaution():
    assert precautions(None) == precautions(record())
    assert locks_of(record(), (), TODAY) == {}


def test_an_unknown_diagnosis_is_refused():
    with pytest.raises(Refused, match="one of none, stroke"):
        template("hangover")


@pytest.mark.parametrize(
    ("changes", "halved", "spastic", "skin_s", "kind"),
    [
        ({"diagnosis": "stroke"}, False, True, 0.0, "mas1+"),
        ({"diagnosis": "stroke", "mas": "0"}, False, False, 0.0, "healthy"),
        ({"diagnosis": "stroke", "mas": "1"}, False, False, 0.0, "healthy"),
        ({"diagnosis": "stroke", "mas": "1+"}, False, True, 0.0, "mas1+"),
        ({"diagnosis": "stroke", "mas": "2"}, False, True, 0.0, "mas2"),
        ({"diagnosis": "stroke", "mas": "3"}, False, True, 0.0, "mas3"),
        ({"diagnosis": "stroke", "mas": "4"}, False, True, 0.0, "mas3"),
        ({"diagnosis": "stroke", "mas": "0", "unaware": True}, False, False, 600.0, "healthy"),
        ({"insensate": True}, True, False, 600.0, "healthy"),
        ({"rheumatoid": True}, True, False, 0.0, "healthy"),
        ({"crps": True}, True, False, 0.0, "healthy"),
        ({"diagnosis": "rheumatoid-arthritis"}, True, False, 0.0, "healthy"),
        ({"diagnosis": "crps"}, True, False, 0.0, "healthy"),
        ({"diagnosis": "nerve-lesion"}, True, False, 600.0, "healthy"),
        ({"diagnosis": "burn"}, True, False, 600.0, "contracture"),
    ],
)
def test_precautions(changes, halved, spastic, skin_s, kind):
    found = precautions(record(**changes))
    assert (found.halved, found.spastic, found.skin_check_s, found.kind) == (halved, spastic, skin_s, kind)
    assert any("halved" in note for note in found.notes) == halved
    assert any("skin" in note for note in found.notes) == bool(skin_s)


def test_a_rigid_hand_is_rehearsed_as_the_stiffest_known():
    assert precautions(record("stroke", mas="4")).stiffness_nm_rad > 0.64
    assert precautions(record("stroke", mas="3")).stiffness_nm_rad == 0.0


def test_hyperextension_is_a_statement_of_its_own():
    assert not precautions(record("stroke")).hyperextension
    assert precautions(record(hyperextension_allowed=True)).hyperextension


def test_what_stands_beside_the_diagnosis_locks_as_well():
    beside = record("stroke", rheumatoid=True, crps=True)
    assert [one.key for one in templates_of(beside)] == ["stroke", "rheumatoid-arthritis", "crps"]
    assert set(locks_of(beside, (), TODAY)) == {"passive", "resistive"}
    assert [one.key for one in templates_of(record("crps", crps=True))] == ["crps"]


def test_the_full_range_is_refused_while_a_repair_is_young():
    young = record("flexor-tendon-repair", event_date="2026-05-20")
    assert needs_own_range(young, TODAY) is template("flexor-tendon-repair")
    assert needs_own_range(replace(young, event_date=""), TODAY) is not None
    assert needs_own_range(record("flexor-tendon-repair"), TODAY) is None
    assert needs_own_range(record("stroke", event_date=""), TODAY) is None


def test_templates_are_keyed_and_dated():
    assert len(set(KEYS)) == len(TEMPLATES) == 9
    for one in TEMPLATES:
        assert one.event or not any(0 < lock.from_day < 1e6 for lock in one.locks)
        assert all(lock.why for lock in one.locks)


def test_the_page_for_clinicians_says_what_the_software_does():
    rows = {}
    for line in PAGE.read_text().splitlines():
        if line.startswith("| `"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            rows[cells[0].strip("`")] = cells[1:]
    assert list(rows) == list(KEYS)
    for one in TEMPLATES:
        event, *days, besides = rows[one.key]
        locked = {lock.mode: lock.from_day for lock in one.locks}
        said = [
            "by act" if locked.get(mode) == BY_ACT_ONLY else f"{locked.get(mode, 0):.0f}" for mode in MODES
        ]
        assert (event, days) == (one.event, said), one.key
        assert ("torque halved" in besides) == one.halved
        assert ("skin check" in besides) == bool(one.skin_check_s)
        assert ("spastic" in besides) == one.spastic
        until = f"to day {one.own_range_until_day:.0f}"
        assert (until in besides) == bool(one.own_range_until_day)
