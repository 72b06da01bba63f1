"""A computed grasp is approved and played: the session names the target, and its review aims at it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.grasp.hand import human_hand
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import find_posture
from rehab_app.grasp.spiral import spiral_path
from rehab_app.grasp.target_json import StoredTarget, target_from_json
from rehab_app.recording.grasp_take import write_grasp_take
from rehab_app.services.grip_target import GripChoice, make_target, recorded_choice, way_to_go
from rehab_app.services.order import Order
from robot_iface.kinematics import average_hand
from sessions.store import SessionReader

THING = Cylinder(0.03)


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    folder = tmp_path_factory.mktemp("played")
    hand = human_hand(average_hand())
    posture = find_posture(hand, THING)
    write_grasp_take(
        folder / "grasp.mcap",
        spiral_path(posture),
        hand,
        exercise="cylinder",
        software_version="0",
        target=StoredTarget(THING, "transverse", dict(posture.angles_rad)),
        closing_s=1.5,
        hold_s=0.5,
    )
    with open_clinic(folder / "clinic") as opened:
        opened.takes.approve(opened.takes.get(folder / "grasp.mcap").id, CONSOLE)
        yield opened


@pytest.mark.parametrize(("device", "near_m"), [("exoskeleton", 0.020), ("dlr-hit-ii", 0.012)])
def test_a_session_that_played_a_grasp_names_its_target(clinic, device, near_m):
    (take,) = clinic.takes.list()
    prepared = clinic.therapy.plan(take.id, Order(device=device, speed=1.0, repetitions=1), actor=CONSOLE)
    played = clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE)
    with SessionReader(played.path) as session, SessionReader(take.path) as parent:
        said = session.header.prescription
        assert target_from_json(said) == target_from_json(parent.header.prescription)
    assert json.loads(said)["mode"] == "passive"
    replay = clinic.sessions.replay(played.session)
    choice = recorded_choice(replay.prescription)
    assert choice == GripChoice(THING, "transverse")
    assert replay.worn == (device == "exoskeleton")
    target = make_target(choice, replay.geometry)
    ways = [way_to_go(target, joints, worn=replay.worn) for joints in replay.patient_joints_rad[::5]]
    to_go_m = np.array([way.farthest_m for way in ways if way is not None])
    assert to_go_m[0] > 0.05
    assert to_go_m.min() < near_m


def test_the_take_itself_names_its_target_too(clinic):
    (take,) = clinic.takes.list()
    replay = clinic.sessions.replay(take.id)
    assert recorded_choice(replay.prescription) == GripChoice(THING, "transverse")
    assert replay.worn
