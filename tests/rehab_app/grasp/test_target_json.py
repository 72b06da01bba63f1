"""A target grip as files keep it."""

from __future__ import annotations

import json

import pytest

from rehab_app.grasp.objects import Box, Cylinder, Sphere
from rehab_app.grasp.target_json import StoredTarget, target_from_json, target_to_json, with_target
from rehab_app.services.grip_target import GripChoice, recorded_choice

ANGLES = {"index_pip": 0.7, "thumb_ip": 0.2}


@pytest.mark.parametrize("thing", [Cylinder(0.0225), Sphere(0.03), Box(0.02, 0.05)])
@pytest.mark.parametrize("grip", ["transverse", "diagonal"])
def test_what_is_kept_is_read_back_also_from_a_session_that_played_it(thing, grip):
    target = StoredTarget(thing, grip, ANGLES)
    take = target_to_json(target)
    assert target_from_json(take) == target
    session = with_target('{"mode":"passive","repetitions":3}', take)
    assert target_from_json(session) == target
    assert json.loads(session)["repetitions"] == 3
    assert recorded_choice(session) == GripChoice(thing, grip)


def test_a_recorded_take_leaves_a_prescription_as_it_is():
    asked = '{"mode":"passive"}'
    assert with_target(asked, "") == asked
    assert target_from_json(asked) is None
    assert recorded_choice(asked) is None


@pytest.mark.parametrize(
    "content",
    [
        {"grip": "transverse"},
        {"grip": "hook", "object": {"kind": "cylinder", "radius_m": 0.02}, "angles_rad": {}},
        {"grip": "transverse", "object": {"kind": "cone", "radius_m": 0.02}, "angles_rad": {}},
        {"grip": "transverse", "object": {"kind": "cylinder", "radius_m": -1.0}, "angles_rad": {}},
        {"grip": "transverse", "object": {"kind": "cylinder", "radius_m": "x"}, "angles_rad": {}},
        {"grip": "transverse", "object": [], "angles_rad": {}},
        {"grip": "transverse", "object": {"kind": "cylinder", "radius_m": 0.02}, "angles_rad": []},
        {"grip": "transverse", "object": {"kind": "cylinder", "radius_m": 0.02}, "angles_rad": {"a": None}},
        {"grip": "transverse", "object": {"kind": "cylinder", "radius_m": 0.02}, "angles_rad": {"a": "nan"}},
        [],
    ],
)
def test_what_cannot_be_read_is_no_target(content):
    assert target_from_json(json.dumps({"target": content})) is None
