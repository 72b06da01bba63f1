"""Pictures at a level: what goes wrong in them, and that truth and clock stay those of the scene."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from rehab_app.cameras import CLEAN, FACING, LEVELS, virtual_camera, virtual_cameras
from rehab_app.cameras.paper_markers import Papers, PlacedMarkers, draw, sound_papers
from rehab_app.cameras.picture_trouble import PictureTrouble
from rehab_app.cameras.ray_cast import SurfaceImage
from rehab_app.geometry.pinhole import KINECT
from rehab_app.hand.protocol import load_protocol
from sessions.errors import Refused
from sessions.records.fields import Float64

PROTOCOL = load_protocol("thesis25")
LIGHT = np.array([0.0, 0.0, -1.0])
HAND_PX = np.array([[260.0, 180.0], [380.0, 300.0]])


def trouble(level: str, seed: int = 0) -> PictureTrouble:
    return PictureTrouble(LEVELS[level], seed, KINECT, 30.0, HAND_PX, 0.7)


def test_same_seed_same_pictures_other_seed_another_hand() -> None:
    one, same, other = (
        virtual_camera("mixed", "right", 3.0, PROTOCOL, seed=seed, level="hard") for seed in (1, 1, 2)
    )
    assert np.array_equal(one.frame(40).colour_bgr, same.frame(40).colour_bgr)
    assert np.array_equal(one.frame(40).depth_m, same.frame(40).depth_m)
    assert not np.allclose(one.truth(1.0).pixel_px, other.truth(1.0).pixel_px, atol=5.0)


def test_without_a_level_nothing_is_changed() -> None:
    camera = virtual_camera("still", "right", 3.0, PROTOCOL, noise=CLEAN)
    with camera:
        assert [frame.dropped for frame in islice(camera.frames(), 20)] == [0] * 20
    assert (camera.truth(0.0).seen > 0.5).sum() >= 24


def test_lost_frames_are_counted_and_leave_gaps_in_time() -> None:
    with virtual_camera("mixed", "right", 4.0, PROTOCOL, seed=3, level="extreme") as camera:
        frames = list(islice(camera.frames(), 100))
    times = np.array([frame.t_capture_ns for frame in frames])
    assert (np.rint(np.diff(times) * 30e-9) == [frame.dropped + 1 for frame in frames[1:]]).all()
    assert sum(frame.dropped for frame in frames) > 0
    assert sum(frame.dropped for frame in frames[:30]) == 0


def test_shares_of_missing_markers_and_bad_depth() -> None:
    drawn = [trouble("hard").papers(index, 25) for index in range(30, 1030)]
    error = np.array([papers.depth_error_m for papers in drawn])
    assert 1.0 - np.mean([papers.shown for papers in drawn]) == pytest.approx(0.06, abs=0.005)
    assert np.mean(np.isnan(error)) == pytest.approx(0.06, abs=0.005)
    wrong = np.abs(error[np.isfinite(error) & (error != 0.0)])
    assert wrong.size / error.size == pytest.approx(0.03 * 0.94, abs=0.003)
    assert 0.02 <= wrong.min() < wrong.max() <= 0.10
    assert all(trouble("extreme").papers(index, 25).shown.all() for index in range(30))


def test_false_markers_come_in_the_stated_number_and_some_stay() -> None:
    spots = [trouble("hard").false_markers(index, HAND_PX, 0.7) for index in range(400)]
    counts = [int(one.papers.shown.sum()) for one in spots]
    assert np.mean(counts) == pytest.approx(3.5 + 0.9 * 3, rel=0.05)
    first = [one.placed.p_camera_m[:3] for one in spots]
    assert np.ptp(np.array(first), axis=0).max() == 0.0
    pixel = KINECT.project(np.concatenate([one.placed.p_camera_m for one in spots]))
    assert ((pixel > -1.0) & (pixel < [640.0, 480.0])).all()


def drawing() -> tuple[SurfaceImage, np.ndarray[tuple[int, ...], np.dtype[np.uint8]]]:
    depth = np.full((480, 640), 1.0, np.float32)
    return SurfaceImage((0, 480, 0, 640), depth, depth), np.full((480, 640, 3), 120, np.uint8)


def placed() -> PlacedMarkers:
    points: Float64 = KINECT.lift(np.array([[200.0, 200.0], [300.0, 200.0], [400.0, 200.0]]), np.full(3, 0.7))
    return PlacedMarkers(points, -points / np.linalg.norm(points, axis=1, keepdims=True))


def test_a_missing_marker_is_not_drawn_and_bad_depth_is_bad_only_there() -> None:
    surface, colour = drawing()
    papers = sound_papers(3)
    papers.shown[0] = False
    papers.depth_error_m[1], papers.depth_error_m[2] = 0.05, np.nan
    seen = draw(placed(), papers, surface, colour, LIGHT, KINECT)
    assert seen[0] == 0.0
    assert seen[1:] == pytest.approx(1.0, abs=0.05)
    assert (colour[195:206, 195:206] == 120).all()
    assert surface.depth_m[200, 300] == pytest.approx(0.75, abs=1e-3)
    assert surface.depth_m[200, 400] == 0.0
    assert surface.depth_m[200, 320] == 1.0


def test_a_spot_without_a_ring_has_no_white_about_it() -> None:
    surface, colour = drawing()
    sound = sound_papers(3)
    bare = Papers(sound.disc_radius_m, sound.disc_radius_m.copy(), sound.depth_error_m, sound.shown)
    draw(placed(), bare, surface, colour, LIGHT, KINECT)
    assert (colour.min(axis=2) > 160).sum() == 0
    draw(placed(), sound, surface, colour, LIGHT, KINECT)
    assert (colour.min(axis=2) > 160).sum() > 60


def test_light_wavers_by_the_stated_share() -> None:
    grey = np.full((8, 8, 3), 100, np.uint8)
    lit = np.array([trouble("hard").lit(grey, t_s).mean() for t_s in np.linspace(0.0, 60.0, 900)])
    assert 0.6 * 22 < lit.max() - 100.0 < 1.3 * 22
    assert 0.6 * 22 < 100.0 - lit.min() < 1.3 * 22
    assert trouble("hard").lit(grey, 1.0).shape == grey.shape


def test_blur_moves_no_centre_and_spreads_along_the_motion() -> None:
    image = np.zeros((60, 60, 3), np.uint8)
    image[28:33, 28:33] = 250
    trouble("hard").blurred(image, (0, 60, 0, 60), np.array([360.0, 0.0]))  # 6 px in an exposure
    weight = image[..., 0].astype(float)
    rows, columns = np.mgrid[0:60, 0:60]
    assert (weight * columns).sum() / weight.sum() == pytest.approx(30.0, abs=0.1)
    assert (weight * rows).sum() / weight.sum() == pytest.approx(30.0, abs=0.1)
    assert np.flatnonzero(weight.sum(axis=0)).size >= 10
    assert np.flatnonzero(weight.sum(axis=1)).size == 5


def test_two_cameras_see_one_hand_on_one_clock() -> None:
    front, back = virtual_cameras("cylinder", "right", 4.0, PROTOCOL, level="hard", views=FACING, seed=4)
    assert front.time_ns(17) == back.time_ns(17)
    view = FACING[1]
    for t_s in (0.5, 2.2):
        one, other = front.truth(t_s), back.truth(t_s)
        there = other.landmarks_camera_m @ view.rotation_tracking_camera.T + view.p_tracking_camera_m
        assert there == pytest.approx(one.landmarks_camera_m)
    grasp = [(camera.truth(2.2).seen > 0.5) for camera in (front, back)]
    assert (grasp[1] & ~grasp[0]).sum() >= 2  # fingertips that the first camera cannot see
    depth = back.frame(3).depth_m
    assert depth is not None
    assert (depth[depth > 0.0] < 1.0).sum() > 1000


def test_refusals() -> None:
    with pytest.raises(Refused, match="one of easy"):
        virtual_camera("mixed", "right", 3.0, PROTOCOL, level="impossible")
    with pytest.raises(Refused, match="one of fist"):
        virtual_camera("juggling", "right", 3.0, PROTOCOL, level="easy")
