from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from rehab_app.calibration import Corners, Rejected
from rehab_app.calibration.board import Board
from rehab_app.calibration.pictures import at_once, files_named, look_for, pictures, pictures_of
from rehab_app.cameras.frame import Frame, Outage
from rehab_app.errors import Refused
from rehab_app.geometry.pinhole import KINECT


@pytest.fixture
def folder(tmp_path):
    for number in (10, 2, 1):
        cv2.imwrite(str(tmp_path / f"left{number}.png"), np.full((48, 64), number, np.uint8))
    (tmp_path / "notes.txt").write_text("not a picture")
    return tmp_path


def test_pictures_come_in_natural_order(folder):
    names = ["left1.png", "left2.png", "left10.png"]
    for source in (str(folder), str(folder / "left*.png")):
        assert [item.name for item in pictures([source])] == names
    assert [path.name for path in files_named([str(folder / "left2.png")])] == ["left2.png"]
    assert [int(item.grey[0, 0]) for item in pictures([str(folder)])] == [1, 2, 10]


def test_what_is_no_picture(folder):
    (folder / "broken.png").write_bytes(b"\x89PNG but no more")
    (folder / "empty.jpg").write_bytes(b"")
    rejected = [item for item in pictures([str(folder)]) if isinstance(item, Rejected)]
    assert {item.source for item in rejected} == {"broken.png", "empty.jpg"}
    (folder / "none").mkdir()
    for source, value in (
        ("none", "without pictures"),
        ("gone.png", "not there"),
        ("notes.txt", "ending in .txt"),
    ):
        with pytest.raises(Refused, match=value):
            list(pictures([str(folder / source)]))


def test_a_video_is_looked_at_here_and_there(tmp_path, scene):
    path = str(tmp_path / "board.avi")
    writer = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*"MJPG"), 30.0, (640, 480))
    rng = np.random.default_rng(1)
    shown = [scene.picture(*scene.pose(rng), fine=1) for _ in range(3)]
    for number in range(150):
        writer.write(np.repeat(shown[number % 3][:, :, None], 3, axis=2))
    writer.release()
    seen = list(pictures([path]))
    assert len(seen) == 75
    found = look_for(scene.board, seen[:3])
    assert all(isinstance(item, Corners) for item in found)


def test_a_live_camera_is_looked_at_a_few_times_a_second():
    image = np.zeros((48, 64, 3), np.uint8)
    captures = [
        Outage(n * 33_000_000, "unplugged") if n < 10 else Frame(n * 33_000_000, image, None, KINECT)
        for n in range(300)
    ]
    seen = list(pictures_of(iter(captures), 3.0))
    assert 6 <= len(seen) <= 8
    assert seen[0].name == "frame 10"


def test_another_board_is_named(scene):
    image = scene.picture(np.array([0.2, 0.1, 0.0]), np.array([-0.1, -0.06, 0.4]))
    wanted = Board("chessboard", 9, 7, 0.025)
    from rehab_app.calibration.pictures import Picture

    told = []
    found = look_for(wanted, [Picture("a.png", image)], lambda done, total: told.append((done, total)))
    assert found[0].reason.endswith("but one of 9 x 6")
    assert told == [(1, None)]


def test_pictures_are_paired_by_their_number_else_by_their_place(scene):
    one = scene.many(np.random.default_rng(1), 1)[0]

    def named(*names):
        return [replace(one, source=name) for name in names]

    lost = Rejected("l3.png", "does not show the board")
    pairs = at_once([[*named("l1.png", "l2.png"), lost], named("r2.png", "r3.png", "r1.png")])
    sources = [[pair[camera].source for camera in sorted(pair)] for pair in pairs]
    assert sources == [["l1.png", "r1.png"], ["l2.png", "r2.png"], ["r3.png"]]
    pairs = at_once([named("a.png", "b.png"), named("c.png", "d.png")])
    assert [[pair[0].source, pair[1].source] for pair in pairs] == [["a.png", "c.png"], ["b.png", "d.png"]]
    with pytest.raises(Refused, match="2 and 1"):
        at_once([named("a.png", "b.png"), named("c.png")])
