from __future__ import annotations

import re
import struct
import zlib

import cv2
import numpy as np
import pytest

from rehab_app.calibration import Corners, find_board, parse_board
from rehab_app.calibration.board_print import draw_board, write_board
from rehab_app.errors import Refused


def test_boards_as_people_type_them():
    board = parse_board("9x6", 0.025)
    assert (board.kind, board.columns, board.rows, board.one_way_up) == ("chessboard", 9, 6, True)
    assert board.points_m[1].tolist() == [0.025, 0.0, 0.0]
    assert np.allclose(board.points_m[-1], [8 * 0.025, 5 * 0.025, 0.0])
    assert not parse_board("chessboard:8x6", 0.03).one_way_up
    marked = parse_board("ChArUco:7x5", 0.04, dictionary="5x5_100")
    assert (marked.kind, marked.columns, marked.rows, marked.marker_m) == ("charuco", 6, 4, 0.03)
    assert "7 x 5 squares of 40 mm" in marked.description


@pytest.mark.parametrize(
    ("arguments", "value"),
    [
        (("9by6", 0.025), "'9by6'"),
        (("9x6", 25.0), "25 m"),
        (("9x6", float("nan")), "nan m"),
        (("2x6", 0.025), "2 x 6"),
        (("9x600", 0.025), "9 x 600"),
        (("charuco:7x5", 0.03, 0.03), "0.03 m"),
        (("charuco:7x5", 0.03, 0.02, "9x9_1"), "'9x9_1'"),
    ],
)
def test_what_is_no_board(arguments, value):
    with pytest.raises(Refused) as refusal:
        parse_board(*arguments)
    assert value in str(refusal.value)


@pytest.mark.parametrize("spec", ["9x6", "charuco:7x5", "charuco:8x6"])
def test_a_printed_board_has_its_true_size_and_is_found(tmp_path, spec):
    board = parse_board(spec, 0.025)
    path = write_board(draw_board(board), tmp_path / "board.png")
    content = path.read_bytes()
    place = content.index(b"pHYs")
    dots_per_m, vertical, unit = struct.unpack(">IIB", content[place + 4 : place + 13])
    assert (vertical, unit) == (dots_per_m, 1)
    assert struct.unpack(">I", content[place + 13 : place + 17])[0] == zlib.crc32(content[place : place + 13])
    found = find_board(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), board, "board.png")
    assert isinstance(found, Corners)
    assert len(found.index) == board.columns * board.rows
    across_m = np.linalg.norm(found.pixel_px[-1] - found.pixel_px[0]) / dots_per_m
    assert across_m == pytest.approx(np.linalg.norm(board.points_m[-1]), abs=1e-4)


def test_the_same_drawing_as_svg_and_pdf(tmp_path):
    drawing = draw_board(parse_board("9x6", 0.025))
    svg = write_board(drawing, tmp_path / "b.svg").read_text()
    assert 'width="297mm" height="210mm"' in svg
    assert "h25.0000v25.0000h-25.0000z" in svg
    pdf = write_board(drawing, tmp_path / "b.pdf").read_bytes()
    page = [float(number) for number in re.search(rb"MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf).groups()]
    assert page == pytest.approx([297 / 25.4 * 72, 210 / 25.4 * 72], abs=1e-3)
    start = int(re.search(rb"startxref\n(\d+)", pdf)[1])
    assert pdf[start : start + 4] == b"xref"
    for number, offset in enumerate(re.findall(rb"(\d{10}) 00000 n", pdf), start=1):
        assert pdf[int(offset) :].startswith(b"%d 0 obj" % number)
    drawn = zlib.decompress(re.search(rb"stream\n(.*?)\nendstream", pdf, re.DOTALL)[1])
    assert drawn.count(b" 70.8661 70.8661 re") == 35


def test_paper_that_is_too_small(tmp_path):
    with pytest.raises(Refused, match="at most 297 x 210 mm"):
        draw_board(parse_board("9x6", 0.04), "a4")
    assert draw_board(parse_board("9x6", 0.04)).width_m > 0.4
    with pytest.raises(Refused, match="--paper"):
        draw_board(parse_board("9x6", 0.025), "A9")
    with pytest.raises(Refused, match=r"\.pdf"):
        write_board(draw_board(parse_board("9x6", 0.025)), tmp_path / "b.doc")
