from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.calibration import Rejected, calibrate_intrinsics, find_board
from rehab_app.errors import Refused
from rehab_app.geometry.lens import STRAIGHT

GRID = np.stack(np.meshgrid(np.linspace(60, 580, 9), np.linspace(60, 420, 7)), axis=-1).reshape(-1, 2)


def numbers(found):
    return np.array([found.fx_px, found.fy_px, found.cx_px, found.cy_px])


def test_the_camera_is_recovered_within_the_stated_uncertainty(scene):
    scores = []
    for seed in range(12):
        fit = calibrate_intrinsics(scene.many(np.random.default_rng(seed)), scene.board)
        scores.append((numbers(fit.intrinsics) - numbers(scene.intrinsics)) / fit.intrinsics_std_px)
        assert fit.rms_px == pytest.approx(0.15 * np.sqrt(2), rel=0.1)
        assert fit.verdict.word in ("good", "usable")
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.5
    assert np.abs(scores).max() < 4.5


def test_drawn_pictures_give_the_camera_back(scene):
    rng = np.random.default_rng(5)
    found = []
    while len(found) < 8:
        corners = find_board(scene.picture(*scene.pose(rng), fine=2), scene.board, f"{len(found)}.png")
        if not isinstance(corners, Rejected):
            found.append(corners)
    fit = calibrate_intrinsics(found, scene.board)
    assert fit.rms_px < 0.1
    assert np.abs(numbers(fit.intrinsics) - numbers(scene.intrinsics)).max() < 1.5
    true, own = (one.undistorted(GRID, scene.intrinsics) for one in (scene.lens, fit.lens))
    assert np.abs(true - own).max() < 1.0


def test_only_a_lens_that_the_images_support_is_claimed(make_scene):
    plain = make_scene(lens=STRAIGHT)
    fits = [calibrate_intrinsics(plain.many(np.random.default_rng(seed)), plain.board) for seed in range(20)]
    assert sum(fit.lens.straight for fit in fits) >= 8
    for fit in fits:
        off = numbers(fit.intrinsics) - numbers(plain.intrinsics)
        assert (np.abs(off) < 4.5 * fit.intrinsics_std_px).all()
    bent = make_scene()
    fit = calibrate_intrinsics(bent.many(np.random.default_rng(1)), bent.board)
    assert fit.model.startswith("k1 k2")
    assert not fit.lens.folds(fit.intrinsics)


def test_the_order_of_the_images_does_not_matter(scene):
    rng = np.random.default_rng(2)
    seen = scene.many(rng)
    first = calibrate_intrinsics(seen, scene.board)
    second = calibrate_intrinsics([seen[row] for row in rng.permutation(len(seen))], scene.board)
    assert np.allclose(numbers(first.intrinsics), numbers(second.intrinsics), rtol=1e-6)
    assert {view.source for view in first.views} == {view.source for view in second.views}
    assert first.verdict == second.verdict


def test_an_image_that_does_not_fit_is_left_out_and_named(scene):
    seen = scene.many(np.random.default_rng(3))
    crooked = seen[4].pixel_px.copy()
    crooked[::5] += 6.0
    fit = calibrate_intrinsics([*seen[:4], replace(seen[4], pixel_px=crooked), *seen[5:]], scene.board)
    assert [(item.source, "does not fit" in item.reason) for item in fit.rejected] == [("image04.png", True)]
    clean = calibrate_intrinsics([*seen[:4], *seen[5:]], scene.board)
    assert np.allclose(numbers(fit.intrinsics), numbers(clean.intrinsics))


def test_twins_count_once_and_a_long_video_is_thinned(scene):
    rng = np.random.default_rng(4)
    seen = scene.many(rng, 8)
    fit = calibrate_intrinsics([*seen, replace(seen[0], source="again.png")], scene.board)
    assert len(fit.views) == 8
    assert "shows the board as" in fit.rejected[0].reason
    fit = calibrate_intrinsics(scene.many(rng, 60), scene.board)
    assert len(fit.views) == 40
    assert len(fit.rejected) == 20


def test_boards_that_never_tilt_do_not_pass_as_good(scene):
    rng = np.random.default_rng(6)
    flat = [scene.corners(rng, f"{n}.png", scene.pose(rng, tilt_rad=0.01)) for n in range(10)]
    fit = calibrate_intrinsics(flat, scene.board)
    assert fit.verdict.word == "redo"
    assert "tilt the board" in fit.verdict.why


def test_bad_input_is_one_sentence(scene):
    seen = scene.many(np.random.default_rng(7), 5)
    blank = Rejected("blank.png", "has no contrast")
    for few, value in (([], "0 of 0"), ([blank], "0 of 1; blank.png has no contrast"), (seen[:1], "1 of 1")):
        with pytest.raises(Refused, match="3 or more") as refusal:
            calibrate_intrinsics(few, scene.board)
        assert value in str(refusal.value)
    other = replace(seen[0], size_px=(1280, 720), source="wide.png")
    with pytest.raises(Refused, match=r"size of wide\.png is 1280 x 720, but must be 640 x 480"):
        calibrate_intrinsics([*seen[1:], other], scene.board)
    with pytest.raises(Refused, match="different sides"):
        calibrate_intrinsics([replace(seen[0], source=f"{n}.png") for n in range(6)], scene.board)


def test_real_chessboards(chessboards, scene):
    left, right = (calibrate_intrinsics(one, scene.board) for one in chessboards)
    assert left.rms_px <= 0.2
    assert right.rms_px <= 0.21
    assert left.intrinsics.fx_px == pytest.approx(532.8, abs=1.5)
    assert left.lens.coefficients[0] == pytest.approx(-0.285, abs=0.015)
    for fit in (left, right):
        assert len(fit.views) == 13
        assert not fit.rejected
        assert fit.verdict.word == "good"
