"""The scorer on tracks whose score is known by counting."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rehab_app.cameras.levels import Level
from rehab_app.cameras.sequence import PointSequence, point_sequence
from tests.bench.tracking.score import Tracks, hota, score

CLEAN = Level("clean", 0.2, 0.5, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
FRAMES = 40


@cache
def sequence() -> PointSequence:
    made = point_sequence(CLEAN, 5, FRAMES, exercise="abduction")
    assert made.visible.all()
    return made


def perfect() -> Tracks:
    made = sequence()
    rows = [np.argsort(owner) for owner in made.owner]
    return Tracks(made.pixel_px.copy(), np.array(rows))


def swap(tracks: Tracks, a: int, b: int, first: int, last: int) -> Tracks:
    order = np.arange(25)
    order[[a, b]] = b, a
    pixel, detection = tracks.pixel_px.copy(), tracks.detection.copy()
    pixel[first:last] = tracks.pixel_px[first:last][:, order]
    detection[first:last] = tracks.detection[first:last][:, order]
    return Tracks(pixel, detection)


def test_perfect_tracks_score_one() -> None:
    result = score(sequence(), perfect())
    assert (result.mota, result.idf1) == (1.0, 1.0)
    assert result.hota == pytest.approx(1.0)
    assert (result.switches, result.swaps, result.frames) == (0, 0, FRAMES)
    assert result.rmse_px < 1e-9


def test_a_permanent_exchange_halfway() -> None:
    a, b, half = 3, 20, FRAMES // 2
    result = score(sequence(), swap(perfect(), a, b, half, FRAMES))
    objects = 25 * FRAMES
    assert result.switches == 2
    assert result.mota == pytest.approx(1.0 - 2 / objects)
    assert result.idf1 == pytest.approx(1.0 - 2 * half / objects)  # both ids are half right
    assert result.swaps == 2
    apart = np.linalg.norm(sequence().pixel_px[half:, a] - sequence().pixel_px[half:, b], axis=1)
    assert result.rmse_px == pytest.approx(np.sqrt(2 * (apart**2).sum() / objects))
    # of the matches of either id, each is shared by half: 20 together of a union of 40 + 40 - 20
    association = (objects - 2 * FRAMES + 2 * FRAMES * (20 / 60)) / objects
    assert result.hota == pytest.approx(np.sqrt(association))


def test_an_exchange_of_four_frames_is_no_true_swap_and_five_are() -> None:
    assert score(sequence(), swap(perfect(), 3, 20, 10, 14)).swaps == 0
    assert score(sequence(), swap(perfect(), 3, 20, 10, 15)).swaps == 2


def test_a_track_may_coast_three_captures() -> None:
    tracks = perfect()
    tracks.detection[10:13, 7] = -1
    assert score(sequence(), tracks).mota == 1.0
    tracks.detection[10:16, 7] = -1
    assert score(sequence(), tracks).mota == pytest.approx(1.0 - 3 / (25 * FRAMES))


def test_a_track_beyond_the_radius_is_a_miss_and_a_false_alarm() -> None:
    tracks = perfect()
    tracks.pixel_px[12, 4] += [300.0, 0.0]
    result = score(sequence(), tracks)
    assert result.mota == pytest.approx(1.0 - 2 / (25 * FRAMES))
    assert result.rmse_px == pytest.approx(np.sqrt(300.0**2 / (25 * FRAMES)))


def test_dropped_frames_do_not_count() -> None:
    lost = np.zeros(FRAMES, dtype=np.bool_)
    lost[[5, 6, 30]] = True
    tracks = perfect()
    tracks.pixel_px[lost], tracks.detection[lost] = np.nan, -1
    result = score(replace(sequence(), dropped=lost), tracks)
    assert (result.mota, result.idf1, result.frames) == (1.0, 1.0, FRAMES - 3)


def test_an_estimate_on_a_hidden_marker_is_neither_right_nor_wrong() -> None:
    hidden = sequence().visible.copy()
    hidden[20:22, 7] = False
    partly = replace(sequence(), visible=hidden)
    tracks = perfect()
    tracks.detection[20:22, 7] = -1
    assert score(partly, tracks).mota == 1.0
    strict = score(partly, tracks, set_aside=False)
    assert strict.mota == pytest.approx(1.0 - 2 / (25 * FRAMES - 2))


def test_nothing_said_scores_nothing() -> None:
    silent = Tracks(np.full((FRAMES, 25, 2), np.nan), np.full((FRAMES, 25), -1))
    result = score(sequence(), silent)
    assert (result.idf1, result.hota) == (0.0, 0.0)
    assert np.isnan(result.rmse_px)


def test_hota_of_two_objects_by_hand() -> None:
    costs = np.full((4, 2, 2), np.inf)
    costs[:, 0, 0] = 0.0
    costs[:2, 1, 1] = 0.0  # the second is missed for two of four frames
    seen = np.ones((4, 2), dtype=np.bool_)
    said = np.array([[True, True], [True, True], [True, False], [True, False]])
    association = (4 * 1.0 + 2 * (2 / 4)) / 6
    assert hota(costs, seen, said) == pytest.approx(np.sqrt(association * 6 / 8))
