"""The library: complete, searchable, drawn by the hand's own kinematics; postures that a hand can take."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.cameras import MOTIONS
from rehab_app.errors import Refused
from rehab_app.hand.exercise_postures import POSTURES_DEG, posture_rad
from rehab_app.services.exercise_drawing import VIEWS, draw_pair
from rehab_app.services.exercise_records import PURPOSES
from rehab_app.services.exercises import STARTERS
from rehab_app.services.take_quality import quality_of
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, average_hand, forward
from robot_iface.types import DIGITS, JOINTS, MODES
from sessions.records import LANDMARKS

ASSISTANT = Account("sam", "assistant", "2")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("library")) as clinic:
        yield clinic.exercises


def tip(posture, digit):
    landmarks = forward(average_hand(), posture_rad(posture)).landmarks_m
    return landmarks[LANDMARKS.index(f"{digit}_tip")]


def test_the_starter_set_is_whole():
    names = {one.name for one in STARTERS}
    assert names >= {"straight_fist", "hook_fist", "full_fist", "tabletop", "dip_blocking", "finger_flexion"}
    assert names >= {"place_and_hold", "thumb_abduction", "thumb_extension", "opposition", "wave"}
    assert names >= {"three_jaw_pinch", "key_pinch", "cylinder_grasp"}
    assert names == set(MOTIONS) - {"still"}, "the virtual camera shows every exercise of the library"
    assert len(names) == len(STARTERS) == 19


@pytest.mark.parametrize("one", STARTERS, ids=lambda one: one.name)
def test_every_exercise_says_what_a_therapist_needs(one):
    assert one.words
    assert one.purpose
    assert len(one.instructions) >= 3
    assert one.joints
    assert one.cautions
    assert set(one.purposes) <= set(PURPOSES)
    assert set(one.digits) <= set(DIGITS)
    assert one.dose.mode in MODES
    assert one.dose.repetitions >= 1
    assert one.dose.minutes >= 1.0
    assert one.start != one.end
    moved = np.flatnonzero(np.abs(posture_rad(one.end) - posture_rad(one.start)) > np.deg2rad(8.0))
    assert {JOINTS[row].partition("_")[0] for row in moved} & set(one.digits)


@pytest.mark.parametrize("name", POSTURES_DEG)
def test_postures_are_within_the_range_of_hands(name):
    assert set(POSTURES_DEG[name]) <= set(JOINTS)
    angles = posture_rad(name)
    assert (angles >= JOINT_MIN_RAD).all()
    assert (angles <= JOINT_MAX_RAD).all()


@pytest.mark.parametrize(
    ("posture", "digit"),
    [
        ("tip pinch", "index"),
        ("thumb to index", "index"),
        ("thumb to ring", "ring"),
        ("three-jaw pinch", "middle"),
    ],
)
def test_a_pinch_brings_the_tips_together(posture, digit):
    """Centres of the tips are a finger's thickness apart, and far apart with the hand open."""
    assert np.linalg.norm(tip(posture, "thumb") - tip(posture, digit)) < 0.025
    assert np.linalg.norm(tip("open", "thumb") - tip("open", digit)) > 0.07


def test_the_thumb_stays_outside_the_fist():
    assert tip("fist", "thumb")[0] > tip("fist", "middle")[0] > 0.0


@pytest.mark.parametrize("view", VIEWS)
def test_every_picture_is_whole_and_inside_its_frame(library, view):
    for one in STARTERS:
        root = ElementTree.fromstring(library.picture(one.name, view, "right"))
        width, height = (float(part) for part in root.attrib["viewBox"].split()[2:])
        limbs = [node for node in root.iter() if node.tag.endswith("path") and node.attrib["fill"] != "none"]
        assert len(limbs) == 2 * (15 + 2)
        boxes = [node for node in root if node.tag.endswith("g")]
        for box in boxes:
            at = float(re.search(r"translate\(([-\d.]+)", box.attrib["transform"]).group(1))
            inner = box[0]
            x, y = (
                float(part)
                for part in re.search(r"\(([-\d.]+) ([-\d.]+)\)", inner.attrib["transform"]).groups()
            )
            for node in inner:
                points = np.array(re.findall(r"([-\d.]+) ([-\d.]+)", node.attrib["d"]), dtype=float)
                points += np.array([x + at, y])
                low, high = points.min(axis=0), points.max(axis=0)
                assert (low >= 0.0).all(), one.name
                assert high[0] <= width, one.name
                assert low[1] <= height, one.name


@pytest.mark.parametrize("view", VIEWS)
def test_a_left_hand_is_the_mirror_image(view):
    pair = [
        draw_pair(posture_rad("open"), posture_rad("fist"), view, side, ("index",))
        for side in ("left", "right")
    ]
    assert pair[0].count("scale(-1 1)") == 2
    assert "scale(-1 1)" not in pair[1]
    assert re.findall(r' d="(M[^h]*?)"', pair[0]) == re.findall(r' d="(M[^h]*?)"', pair[1])


def test_a_moving_digit_differs_by_more_than_its_colour():
    svg = draw_pair(posture_rad("open"), posture_rad("index bent"), "palm", "right", ("index",))
    widths = [float(text) for text in re.findall(r'stroke-width="([\d.]+)"', svg)]
    assert widths.count(2.6) == 2 * 3
    assert widths.count(1.6) == 2 * 14


def test_search_needs_every_word_and_no_accents(library):
    assert {one.name for one in library.list("FIST hook")} == {"hook_fist"}
    assert {one.name for one in library.list("thúmb extension", "thumb")} >= {"thumb_extension"}
    assert library.list("zebra") == ()
    assert all("pinch" in one.purposes for one in library.list(purpose="pinch"))
    with pytest.raises(Refused, match="purpose"):
        library.list(purpose="fun")


def test_a_clinic_adds_its_own_exercises(library):
    added = library.add(CONSOLE, "  Towel / wringing ", "Wring a towel.\r\nBoth hands.")
    assert (added.name, added.own, added.purpose) == ("Towel / wringing", True, "Wring a towel.\nBoth hands.")
    assert library.get("Towel / wringing") in library.list(purpose="own")
    library.add(CONSOLE, "Towel / wringing", "Softly.")
    assert library.get("Towel / wringing").purpose == "Softly."
    with pytest.raises(Refused, match="picture"):
        library.picture("Towel / wringing", "palm", "left")


@pytest.mark.parametrize(
    ("name", "description", "thing"),
    [
        ("", "x", "name of the exercise is empty"),
        ("Hook fist", "x", "name of the exercise"),
        ("PINCH", "x", "name of the exercise"),
        ("x" * 61, "x", "at most 60"),
        ("a\u202eb", "x", "hidden character"),
        ("new", "", "description of the exercise is empty"),
        ("new", "y" * 10_000, "at most 2000"),
    ],
)
def test_a_wrong_exercise_is_refused_in_a_sentence(library, name, description, thing):
    with pytest.raises(Refused, match=re.escape(thing)):
        library.add(CONSOLE, name, description)


def test_only_who_prescribes_adds(library):
    with pytest.raises(Refused, match="may not prescribe"):
        library.add(ASSISTANT, "new", "x")


def test_the_virtual_camera_shows_an_exercise_of_the_library(tmp_path):
    """Its goal is reached in the recorded joints, and most of it was measured."""
    with open_clinic(tmp_path) as clinic:
        row = clinic.takes.record_virtual("hook_fist", "left", 4.5, 3, CONSOLE)
        motion = clinic.takes.motion(row.take)
    reached = np.rad2deg(np.nanmax(motion.joints_rad, axis=0))
    assert reached[JOINTS.index("middle_pip")] == pytest.approx(100.0, abs=6.0)
    assert reached[JOINTS.index("middle_mcp_flexion")] < 15.0
    assert quality_of(motion).measured > 0.8
