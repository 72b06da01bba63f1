"""Target grips: where the object lies, how far a hand is, what is refused and in which words."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.grasp.closing import in_object_frame
from rehab_app.grasp.hand import human_hand
from rehab_app.grasp.posture import find_posture
from rehab_app.grasp.spiral import spiral_path
from rehab_app.hand.retarget import retarget, whole_robot_hand
from rehab_app.services import grip_finder
from rehab_app.services.grip_finder import NO_GRIP, GripFinder
from rehab_app.services.grip_target import (
    GripChoice,
    GripTarget,
    choice_fields,
    grip_choice,
    make_target,
    way_to_go,
)
from rehab_app.services.live_target import LiveTarget, way_of
from rehab_app.services.snapshot import LiveSnapshot
from rehab_app.therapy.reference_grasp import reference_from_grasp
from rehab_app.therapy.run_poses import run_hand
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand, forward
from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, dlr_hit_hand, hand_points
from robot_iface.safety import shipped_limits
from robot_iface.types import Side
from sessions.records import JOINTS

HAND = average_hand()
CYLINDER = grip_choice("cylinder", 45.0)
assert CYLINDER is not None


@pytest.fixture(scope="module")
def target() -> GripTarget:
    assert CYLINDER is not None
    return make_target(CYLINDER, HAND)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("size_mm", "grip"), [(45.0, "transverse"), (60.0, "diagonal")])
def test_hand_and_object_lie_to_each_other_as_the_posture_says(side: Side, size_mm: float, grip: str) -> None:
    hand = average_hand(0.175, side)
    choice = grip_choice("cylinder", size_mm, grip)
    assert choice is not None
    made = make_target(choice, hand)
    posture = find_posture(human_hand(hand), choice.thing, grip)
    assert np.linalg.det(made.r_palm_object) == pytest.approx(1.0)
    digits = forward(hand, made.joints_rad).landmarks_m[:20]
    seen = (digits - made.p_palm_object_m) @ made.r_palm_object
    np.testing.assert_allclose(np.abs(seen), np.abs(posture.points_m.reshape(20, 3)), atol=1e-12)
    # the oracle that posture was closed with, and a point of the palm that is on no digit
    point = np.array([[0.01, 0.02, 0.03]])
    there = in_object_frame(
        posture.hand, posture.thing, np.array([posture.z_m]), np.array([posture.alpha_rad]), point
    )[0]
    here = (point * hand.mirror - made.p_palm_object_m) @ made.r_palm_object
    np.testing.assert_allclose(np.abs(here), np.abs(there), atol=1e-12)
    assert made.aperture_rad == pytest.approx(posture.aperture_rad, abs=1e-9)


def test_the_way_is_nothing_at_the_target_and_the_farthest_touching_digit_elsewhere(
    target: GripTarget,
) -> None:
    there = way_to_go(target, target.joints_rad)
    assert there is not None
    assert there.farthest_m == 0.0
    assert there.aperture_rad == pytest.approx(target.aperture_rad)
    bent = target.joints_rad.copy()
    bent[JOINTS.index("ring_mcp_flexion")] -= 0.2
    way = way_to_go(target, bent)
    assert way is not None
    assert way.farthest == "ring"
    tip = forward(HAND, target.joints_rad).landmarks_m[[12, 15]]
    assert way.farthest_m == pytest.approx(2 * np.sin(0.1) * np.linalg.norm(tip[1] - tip[0]))
    assert way_to_go(target, np.full(21, np.nan)) is None


def test_a_digit_that_does_not_touch_is_shown_and_not_counted() -> None:
    choice = grip_choice("cylinder", 60.0, "diagonal")
    assert choice is not None
    made = make_target(choice, HAND)
    assert made.holds.tolist() == [False, True, True, True, True]
    assert any("thumb" in note for note in made.notes)
    away = made.joints_rad.copy()
    away[JOINTS.index("thumb_mcp_flexion")] += 0.8
    way = way_to_go(made, away)
    assert way is not None
    assert way.fingertip_m[0] > 0.02
    assert way.farthest_m == 0.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("teapot", 60.0), "one of none, cylinder, ball, box"),
        (("cylinder", 60.0, "hook"), "transverse or diagonal"),
        (("cylinder", 0.0), "5 to 300 mm"),
        (("ball", float("nan")), "5 to 300 mm"),
        (("box", 40.0, "transverse", 1e9), "width of the object"),
    ],
)
def test_a_choice_that_is_none_is_a_sentence(arguments: tuple[Any, ...], words: str) -> None:
    with pytest.raises(Refused, match=words):
        grip_choice(*arguments)


@pytest.mark.parametrize(
    "arguments", [("cylinder", 45.0, "diagonal"), ("ball", 62.5), ("box", 40.0, "transverse", 55.0)]
)
def test_the_form_gives_back_what_was_chosen(arguments: tuple[Any, ...]) -> None:
    choice = grip_choice(*arguments)
    fields = choice_fields(choice)
    again = grip_choice(fields["object"], float(fields["size"]), fields["grip"], float(fields["width"]))
    assert again == choice
    assert grip_choice(choice_fields(None)["object"], 0.0) is None


def test_too_large_names_the_diameters_that_this_hand_holds() -> None:
    choice = grip_choice("cylinder", 300.0)
    assert choice is not None
    with pytest.raises(Refused, match=r"300 mm thick, but must be \d+ to \d+ mm for this hand") as refusal:
        make_target(choice, HAND)
    low, high = (float(number) for number in refusal.value.bound.split(" mm")[0].split(" to "))
    for size_mm in (low + 1.0, high - 1.0):
        held = grip_choice("cylinder", size_mm)
        assert held is not None
        make_target(held, HAND)


def found(finder: GripFinder, choice: GripChoice | None, geometry: Any = HAND) -> Any:
    end_s = time.monotonic() + 60.0
    while time.monotonic() < end_s:
        known = finder.find(choice, geometry)
        if known is NO_GRIP or known.target is not None or known.refused:
            return known
        threading.Event().wait(0.01)
    raise AssertionError("never found")


def test_the_finder_never_waits_and_asks_once(monkeypatch: pytest.MonkeyPatch, target: GripTarget) -> None:
    asked: list[str] = []
    go_on = threading.Event()

    def made(choice: GripChoice, geometry: Any) -> GripTarget:
        asked.append(geometry.side)
        assert go_on.wait(60.0)
        return target

    monkeypatch.setattr(grip_finder, "make_target", made)
    finder = GripFinder()
    for _ in range(3):
        first = finder.find(CYLINDER, HAND)
        assert first.target is None
        assert "working it out" in first.words
    go_on.set()
    assert found(finder, CYLINDER).target is target
    # an equal hand is the same hand, another side is another one
    assert finder.find(CYLINDER, average_hand()).target is target
    assert asked == ["right"]
    found(finder, CYLINDER, average_hand(side="left"))
    assert asked == ["right", "left"]
    assert finder.find(None, HAND) is NO_GRIP


def test_the_finder_keeps_refusals_and_survives_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(choice: GripChoice, geometry: Any) -> GripTarget:
        raise Refused("cylinder", "too thick", "thinner", "choose another")

    monkeypatch.setattr(grip_finder, "make_target", refuses)
    finder = GripFinder()
    assert "must be thinner" in found(finder, CYLINDER).words


def test_a_failure_is_a_sentence_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(choice: GripChoice, geometry: Any) -> GripTarget:
        raise ZeroDivisionError

    monkeypatch.setattr(grip_finder, "make_target", breaks)
    monkeypatch.setattr(threading, "excepthook", lambda _: None)
    finder = GripFinder()
    assert "log" in found(finder, CYLINDER).words
    assert found(finder, None) is NO_GRIP


def test_who_may_play_chooses_and_a_demonstration_is_recorded_without(target: GripTarget) -> None:
    noted: list[Any] = []
    audit: Any = SimpleNamespace(note_later=lambda *row, **more: noted.append((*row, more)))
    live = LiveTarget(audit)
    with pytest.raises(Refused):
        live.choose(Account("otto", "auditor", "3"), CYLINDER)
    assert live.choice is None
    live.choose(Account("anna", "therapist", "1"), CYLINDER)
    assert noted == [("anna", "target grip", {"detail": "Cylinder of 45 mm, transverse grip"})]
    assert live.onto(LiveSnapshot(state="playing")).grip is not NO_GRIP
    assert live.onto(LiveSnapshot(state="recording")).grip is NO_GRIP
    live.choose(Account("anna", "therapist", "1"), None)
    assert live.onto(LiveSnapshot(state="playing")).grip is NO_GRIP


def test_a_robot_that_nobody_wears_is_measured_by_its_own_fingertips(target: GripTarget) -> None:
    grip = grip_finder.FoundGrip(target, "x")
    way = way_of(LiveSnapshot(grip=grip, patient_joints_rad=target.joints_rad, worn=True))
    assert way is not None
    assert way.farthest_m == 0.0
    assert way_of(LiveSnapshot(grip=grip)) is None
    ends = np.tile(FINGER_MIN_RAD, 5), np.tile(FINGER_MAX_RAD, 5)
    shown = retarget(HAND, target.joints_rad[None], *ends).joints_rad
    robot = whole_robot_hand(shown)[0]
    there = way_of(LiveSnapshot(grip=grip, patient_joints_rad=robot, worn=False))
    assert there is not None
    assert there.farthest_m == pytest.approx(0.0, abs=1e-12)
    assert there.aperture_rad is None
    bent = robot.copy()
    bent[JOINTS.index("ring_mcp_flexion")] -= 0.2
    away = way_of(LiveSnapshot(grip=grip, patient_joints_rad=bent, worn=False))
    assert away is not None
    points = hand_points(dlr_hit_hand(), shown.reshape(5, 3))[3]
    assert away.farthest == "ring"
    assert away.farthest_m == pytest.approx(2 * np.sin(0.1) * np.linalg.norm(points[3] - points[0]))
    assert way_to_go(target, np.full(21, np.nan), worn=False) is None


@pytest.mark.parametrize(("device", "near_m"), [("dlr-hit-ii", 0.008), ("exoskeleton", 0.020)])
def test_a_grip_that_is_played_reaches_its_own_target(target: GripTarget, device: str, near_m: float) -> None:
    # the path as the motion core gets it, within the device's shipped limits; what they cut off is said there
    hand, known = human_hand(HAND), capabilities(device)
    limits = shipped_limits(known.joint_names, known.q_min_rad, known.q_max_rad)
    built = reference_from_grasp(
        spiral_path(find_posture(hand, target.choice.thing, target.choice.grip)),
        hand,
        patient_side="right",
        device=known,
        limits=limits,
    )
    poses = run_hand(known, HAND).poses(built.path.q_rad).joints_rad
    ways = [way_to_go(target, row, worn=known.worn) for row in poses[:: len(poses) // 40]]
    to_go_m = np.array([way.farthest_m for way in ways if way is not None])
    assert to_go_m[0] > 0.05
    assert to_go_m.min() < near_m
