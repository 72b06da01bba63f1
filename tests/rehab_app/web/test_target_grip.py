"""The target grip in the picture and on the page: lines on their bones, plain words, verbs with bounds."""

from __future__ import annotations

import threading
import time
from contextlib import closing
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rehab_app.grasp.objects import Box, Cylinder, Sphere
from rehab_app.grasp.target_json import StoredTarget, target_to_json, with_target
from rehab_app.services.grip_finder import NO_GRIP, FoundGrip
from rehab_app.services.grip_target import (
    GripChoice,
    GripTarget,
    choice_fields,
    grip_choice,
    make_target,
    way_to_go,
)
from rehab_app.services.rows import Replay
from rehab_app.services.snapshot import LiveSnapshot
from rehab_app.web.live_state import _target
from rehab_app.web.viewport import LiveViewport
from rehab_app.web.viewport.aim import Aim
from rehab_app.web.viewport.drawn_target import DrawnTarget
from rehab_app.web.viewport.goal import goal_html, to_go
from rehab_app.web.viewport.outline import hand_lines_m, thing_lines_m, thing_place
from rehab_app.web.viewport.private_server import PrivateServer
from rehab_app.web.viewport.review import ReviewViewport
from rehab_app.web.viewport.solids import bar, block
from rehab_app.web.viewport.verdict import legend
from robot_iface.kinematics import average_hand, forward

HAND = average_hand(side="left")


def target(kind: str, size_mm: float, width_mm: float = 0.0) -> GripTarget:
    choice = grip_choice(kind, size_mm, width_mm=width_mm)
    assert choice is not None
    return make_target(choice, HAND)


@pytest.fixture(scope="module")
def cylinder() -> GripTarget:
    return target("cylinder", 60.0)


@pytest.mark.parametrize("solid", [bar(), block()], ids=["bar", "block"])
def test_what_is_grasped_is_closed_and_faces_outwards(solid: Any) -> None:
    edges = np.concatenate([solid.faces[:, [0, 1]], solid.faces[:, [1, 2]], solid.faces[:, [2, 0]]])
    assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
    corners = solid.vertices_m[solid.faces]
    assert np.einsum("fi,fi->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0


def test_the_outline_wraps_the_digits(cylinder: GripTarget) -> None:
    lines = hand_lines_m(HAND, cylinder.joints_rad)
    assert lines.shape[1:] == (2, 3)
    assert np.isfinite(lines).all()
    joints = forward(HAND, cylinder.joints_rad).landmarks_m[:20]
    away = np.linalg.norm(lines.reshape(-1, 1, 3) - joints, axis=2)
    # no line is farther from a joint or tip than a phalanx is long; every joint has lines around it
    assert away.min(axis=1).max() < 0.05
    assert away.min(axis=0).max() < 0.025


def test_the_object_is_drawn_where_it_lies_and_as_large_as_it_is(cylinder: GripTarget) -> None:
    middle, size = thing_place(cylinder)
    np.testing.assert_allclose(size[:2], 0.060)
    # the drawing is as long as the hand needs, along the object's own axis
    along = np.cross(middle - cylinder.p_palm_object_m, cylinder.r_palm_object[:, 2])
    np.testing.assert_allclose(along, 0.0, atol=1e-12)
    rim = (thing_lines_m(cylinder).reshape(-1, 3) - middle) @ cylinder.r_palm_object
    np.testing.assert_allclose(np.hypot(rim[:, 0], rim[:, 1]), 0.030)
    ball = target("ball", 70.0)
    np.testing.assert_allclose(thing_place(ball)[0], ball.p_palm_object_m)
    np.testing.assert_allclose(thing_place(ball)[1], 0.070)


def test_the_card_says_how_far_it_is_and_when_it_is_reached(cylinder: GripTarget) -> None:
    found = FoundGrip(cylinder, "Cylinder of 60 mm, transverse grip")
    open_hand = way_to_go(cylinder, np.zeros(21))
    reached = way_to_go(cylinder, cylinder.joints_rad)
    assert open_hand is not None
    assert reached is not None
    html = goal_html(found, open_hand)
    assert f"{1e3 * open_hand.farthest_m:.0f}" in html
    assert to_go(open_hand).endswith(" mm to go")
    assert "degrees of 57" in html
    assert to_go(reached) == "reached"
    assert "Reached" in goal_html(found, reached)
    assert "No hand is measured" in goal_html(found, None)
    assert goal_html(NO_GRIP, None) == ""
    assert "&lt;b&gt;" in goal_html(FoundGrip(words="<b>", refused=True), None)


def test_the_card_of_a_robot_that_nobody_wears_says_whose_fingertips_these_are(cylinder: GripTarget) -> None:
    way = way_to_go(cylinder, np.zeros(21), worn=False)
    html = goal_html(FoundGrip(cylinder, "x"), way)
    assert "mm" in html
    assert "own fingertips" in html
    assert "degrees of" not in html


def test_a_digit_that_is_not_counted_stands_in_brackets() -> None:
    fist = target("cylinder", 30.0)
    assert not fist.holds[0]
    way = way_to_go(fist, np.zeros(21))
    assert goal_html(FoundGrip(fist, "x"), way).count(" mm)") == 1


def test_the_legend_names_only_what_is_shown() -> None:
    assert "Target" not in legend(comparing=True, target=False)
    assert "Patient" not in legend(comparing=False, target=True)
    both = legend(comparing=True, target=True)
    assert all(word in both for word in ("Patient, solid", "Therapist, see-through", "Target, outlined"))


def test_the_scene_shows_one_target_and_takes_it_away(cylinder: GripTarget) -> None:
    server = PrivateServer("test")
    try:
        drawn = DrawnTarget(server, "/hand/target")
        for shown in (cylinder, target("ball", 70.0), target("box", 40.0, 50.0), None):
            drawn.draw(shown)
            assert drawn.shown is shown
    finally:
        server.stop()


def test_the_live_picture_draws_a_target(cylinder: GripTarget) -> None:
    found = FoundGrip(cylinder, "Cylinder of 60 mm, transverse grip")
    shown = LiveSnapshot(state="idle", geometry=HAND, grip=found, patient_joints_rad=cylinder.joints_rad)
    desk = SimpleNamespace(
        snapshot=lambda: shown, camera_jpeg=lambda: None, error_history=lambda: (np.zeros(0), np.zeros(0))
    )
    clinic: Any = SimpleNamespace(live=desk)
    viewport = LiveViewport(clinic)
    try:
        assert viewport.port > 0
    finally:
        viewport.close()
    assert viewport._room.target.shown is cylinder


def test_a_review_that_is_asked_for_nonsense_says_so() -> None:
    server = PrivateServer("test")
    try:
        aim = Aim(server)
        assert aim.found(HAND) is NO_GRIP
        event: Any = None
        aim._object, aim._size = SimpleNamespace(value="Cylinder"), SimpleNamespace(value="wide")
        aim._width = aim._grip = SimpleNamespace(value="Transverse")
        aim._chosen(event)
        assert "5 to 300 mm" in aim.found(HAND).words
        aim._object = SimpleNamespace(value="None")
        aim._chosen(event)
        assert aim.found(HAND) is NO_GRIP
    finally:
        server.stop()


@pytest.mark.parametrize("thing", [Cylinder(0.0225), Sphere(0.035), Box(0.04, 0.055)])
def test_a_review_begins_with_the_grip_that_the_recording_aimed_at(thing: Any) -> None:
    server = PrivateServer("test")
    try:
        aim = Aim(server, GripChoice(thing, "transverse"))
        fields = choice_fields(GripChoice(thing, "transverse"))
        assert aim._object.value == {"cylinder": "Cylinder", "ball": "Ball", "box": "Box"}[fields["object"]]
        assert aim._size.value == pytest.approx(float(fields["size"]))
        assert aim._width.visible == isinstance(thing, Box)
        assert "working it out" in aim.found(HAND).words
        event: Any = None
        chosen = aim._choice
        aim._chosen(event)  # what the widgets show is what was recorded
        assert aim._choice == chosen
    finally:
        server.stop()


def test_a_review_of_a_played_grasp_shows_its_target_and_the_way(cylinder: GripTarget) -> None:
    aimed = target_to_json(StoredTarget(cylinder.choice.thing, cylinder.choice.grip, {}))
    joints = np.linspace(0.0, 1.0, 50)[:, None] * cylinder.joints_rad
    recorded = Replay(
        t_s=np.arange(50) / 50,
        reference_joints_rad=None,
        patient_joints_rad=joints,
        fingertip_error_m=None,
        phases=(),
        events=(),
        geometry=HAND,
        side="left",
        prescription=with_target("{}", aimed),
    )
    with closing(ReviewViewport(recorded, "Review")) as viewport:
        goal, end_s = viewport._panel._goal, time.monotonic() + 60.0
        while "mm to go" not in goal.content and time.monotonic() < end_s:
            threading.Event().wait(0.01)  # its own thread draws, once the grip is worked out
        shown, found = viewport._room.target.shown, viewport._aim.found(HAND).target
    assert shown is found is not None
    assert "Cylinder of 60 mm" in goal.content
    assert "mm to go" in goal.content


def test_the_page_learns_the_way(cylinder: GripTarget) -> None:
    found = FoundGrip(cylinder, "Cylinder of 60 mm, transverse grip")
    told = _target(LiveSnapshot(grip=found, patient_joints_rad=np.zeros(21), geometry=HAND))
    assert told["ready"]
    assert told["farthest"] in ("thumb", "index", "middle", "ring", "little")
    assert told["to_go_mm"] > 50
    assert _target(LiveSnapshot())["to_go_mm"] is None


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"object": "teapot", "size": "60"}, "cylinder, ball, box"),
        ({"object": "cylinder", "size": "x"}, "a number of millimetres"),
        ({"object": "cylinder", "size": "nan"}, "a number of millimetres"),
        ({"object": "cylinder", "size": "900"}, "5 to 300 mm"),
        ({"object": "cylinder", "size": "60", "grip": "<b>"}, "transverse or diagonal"),
        ({"object": "box", "size": "60", "width": ""}, "width of the object"),
    ],
)
def test_a_target_out_of_bounds_is_a_sentence(browser, clinic, fields, words):
    answer = browser("therapist").ask("/live/target", **fields)
    assert answer.status_code == 409
    assert words in answer.json()["message"].lower()
    assert clinic.live.target.choice is None


def test_a_target_is_chosen_by_who_may_play_and_the_form_keeps_it(browser, clinic):
    fields = {"object": "cylinder", "size": "45", "grip": "diagonal"}
    assert browser("auditor").ask("/live/target", **fields).status_code == 403
    assert clinic.live.target.choice is None
    try:
        assert browser("therapist").ask("/live/target", **fields).status_code == 200
        page = browser("therapist").get("/live").text
        assert '<option value="cylinder" selected>' in page
        assert '<option value="diagonal" selected>' in page
        assert 'value="45"' in page
        assert (
            browser("therapist").ask("/live/beat").json()["target"]["words"].startswith("Cylinder of 45 mm")
        )
    finally:
        assert browser("therapist").ask("/live/target", object="none").status_code == 200
    assert clinic.live.target.choice is None
