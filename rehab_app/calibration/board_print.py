"""A board on paper at its true size: SVG, PDF or PNG of the same drawing."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.board import Board, charuco_board, marker_dictionary
from rehab_app.errors import Refused

PAPERS_M: dict[str, tuple[float, float]] = {
    "A4": (0.297, 0.210),
    "letter": (0.2794, 0.2159),
    "A3": (0.420, 0.297),
    "A2": (0.594, 0.420),
    "A1": (0.841, 0.594),
    "A0": (1.189, 0.841),
}
SUFFIXES = (".pdf", ".svg", ".png")
_MARGIN_M = 0.006
_FOOT_M = 0.012  # for the ruler and the words
_RULER_M = 0.1
_PNG_DOTS_PER_M = 11811  # 300 dpi
_POINTS_PER_M = 72 / 0.0254

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Drawing:
    """Black boxes on a white page.

    Attributes:
        width_m: Width of the page.
        height_m: Height of the page.
        boxes_m: Left, top, width and height of each box.
        words: One line at the foot.
        words_m: Where it begins: left, and its base line from the top.
    """

    width_m: float
    height_m: float
    boxes_m: tuple[Box, ...]
    words: str
    words_m: tuple[float, float]


def draw_board(board: Board, paper: str = "") -> Drawing:
    """The board in the middle of a page, with a ruler of 100 mm to prove the printer's scale.

    Args:
        board: The board.
        paper: One of PAPERS_M; by default the smallest of the A sizes that holds it.

    Raises:
        Refused: There is no such paper, or the board does not fit it.
    """
    board_m = ((board.columns + 1) * board.square_m, (board.rows + 1) * board.square_m)
    # white around the squares is part of the board: without it the outer ones are not found
    needed = (board_m[0] + 2 * _MARGIN_M, board_m[1] + 2 * _MARGIN_M + _FOOT_M)
    page = _page(needed, paper)
    left, top = 0.5 * (page[0] - board_m[0]), 0.5 * (page[1] - _FOOT_M - board_m[1])
    ruler = (left, page[1] - _MARGIN_M - 0.004, _RULER_M, 0.001)
    ticks = [(left + step * 0.01 - 0.00025, ruler[1] - 0.002, 0.0005, 0.002) for step in range(11)]
    boxes = [(left + x, top + y, width, height) for x, y, width, height in _squares(board)]
    words = f"{board.description}. Print at 100 %: this line is 100 mm long."
    below = (left, page[1] - _MARGIN_M + 0.0015)
    return Drawing(*page, (*boxes, ruler, *ticks), words, below)


def write_board(drawing: Drawing, path: Path) -> Path:
    """Write the drawing as the file's ending says.

    Args:
        drawing: The page.
        path: A file ending in .pdf, .svg or .png.

    Raises:
        Refused: Another ending.
    """
    writers = {".pdf": _pdf, ".svg": _svg, ".png": _png}
    writer = writers.get(path.suffix.lower())
    if writer is None:
        raise Refused("--out", str(path), "a file ending in .pdf, .svg or .png", "give it that ending")
    path.write_bytes(writer(drawing))
    return path


def _page(needed: tuple[float, float], paper: str) -> tuple[float, float]:
    known = {name.lower(): size for name, size in PAPERS_M.items()}
    if paper and paper.lower() not in known:
        raise Refused("--paper", repr(paper[:20]), "one of " + ", ".join(PAPERS_M), "choose one")
    sizes = [known[paper.lower()]] if paper else [size for name, size in known.items() if name[0] == "a"]
    for wide, high in sizes:
        for page in ((wide, high), (high, wide)):
            if needed[0] <= page[0] and needed[1] <= page[1]:
                return page
    wide, high = sizes[-1]
    raise Refused(
        "board with its margin",
        f"{1e3 * needed[0]:.0f} x {1e3 * needed[1]:.0f} mm",
        f"at most {1e3 * wide:.0f} x {1e3 * high:.0f} mm",
        "choose smaller squares, fewer of them, or larger paper",
    )


def _squares(board: Board) -> list[Box]:
    """Black squares and black cells of markers, from the board's own upper left."""
    side = board.square_m
    columns, rows = board.columns + 1, board.rows + 1
    squares = [
        (x * side, y * side, side, side) for y in range(rows) for x in range(columns) if (x + y) % 2 == 0
    ]
    if board.kind == "charuco":
        squares += _markers(board)
    return squares


def _markers(board: Board) -> list[Box]:
    drawn, dictionary = charuco_board(board), marker_dictionary(board)
    cells = dictionary.markerSize + 2
    size = board.marker_m / cells
    boxes: list[Box] = []
    for number, corners in zip(drawn.getIds().reshape(-1), drawn.getObjPoints(), strict=True):
        pattern: Any = cv2.aruco.generateImageMarker(dictionary, int(number), cells, borderBits=1)
        left, top = np.asarray(corners, dtype=np.float64)[0, :2]
        for row, column in np.argwhere(pattern == 0):
            boxes.append((float(left + column * size), float(top + row * size), size, size))
    return boxes


def _svg(drawing: Drawing) -> bytes:
    wide, high = 1e3 * drawing.width_m, 1e3 * drawing.height_m
    boxes = "".join(
        f"M{1e3 * x:.4f} {1e3 * y:.4f}h{1e3 * width:.4f}v{1e3 * height:.4f}h{-1e3 * width:.4f}z"
        for x, y, width, height in drawing.boxes_m
    )
    left, base = (1e3 * value for value in drawing.words_m)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide:g}mm" height="{high:g}mm" '
        f'viewBox="0 0 {wide:g} {high:g}"><rect width="100%" height="100%" fill="#fff"/>'
        f'<path d="{boxes}" shape-rendering="crispEdges"/>'
        f'<text x="{left:.3f}" y="{base:.3f}" font-family="sans-serif" font-size="3">{drawing.words}</text>'
        "</svg>\n"
    ).encode()


def _pdf(drawing: Drawing) -> bytes:
    scale, high = _POINTS_PER_M, drawing.height_m
    lines = [
        f"{scale * x:.4f} {scale * (high - y - height):.4f} {scale * width:.4f} {scale * height:.4f} re"
        for x, y, width, height in drawing.boxes_m
    ]
    left, base = scale * drawing.words_m[0], scale * (high - drawing.words_m[1])
    words = drawing.words.replace("(", r"\(").replace(")", r"\)")
    content = "\n".join([*lines, "f", f"BT /F1 8 Tf {left:.3f} {base:.3f} Td ({words}) Tj ET"]).encode()
    packed = zlib.compress(content, 9)
    page = (
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {scale * drawing.width_m:.4f} {scale * high:.4f}] "
        "/Resources << /Font << /F1 4 0 R >> >> /Contents 5 0 R >>"
    )
    objects = [
        # without it, viewers offer to shrink the page to what the printer can reach
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        page.encode(),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
        f"<< /Length {len(packed)} /Filter /FlateDecode >>\nstream\n".encode() + packed + b"\nendstream",
    ]
    return _pdf_file(objects)


def _pdf_file(objects: list[bytes]) -> bytes:
    written, places = b"%PDF-1.6\n%\xe2\xe3\xcf\xd3\n", list[int]()
    for number, content in enumerate(objects, start=1):
        places.append(len(written))
        written += f"{number} 0 obj\n".encode() + content + b"\nendobj\n"
    table = "".join(f"{place:010d} 00000 n \n" for place in places)
    return (
        written
        + (
            f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n{table}"
            f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R >>\nstartxref\n{len(written)}\n%%EOF\n"
        ).encode()
    )


def _png(drawing: Drawing) -> bytes:
    """At 300 dpi, which the file states, so that it prints at its true size."""
    scale = _PNG_DOTS_PER_M
    size = (round(scale * drawing.height_m), round(scale * drawing.width_m))
    image = np.full(size, 255, dtype=np.uint8)
    for x, y, width, height in drawing.boxes_m:
        rows = slice(round(scale * y), round(scale * (y + height)))
        image[rows, round(scale * x) : round(scale * (x + width))] = 0
    place = (round(scale * drawing.words_m[0]), round(scale * drawing.words_m[1]))
    cv2.putText(image, drawing.words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.9, (0,), 2, cv2.LINE_AA)
    encoded: Any = cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, 9])[1]
    plain = encoded.tobytes()
    head = 8 + 25  # signature and IHDR; the physical size must come before the picture
    body = b"pHYs" + struct.pack(">IIB", scale, scale, 1)
    return plain[:head] + struct.pack(">I", 9) + body + struct.pack(">I", zlib.crc32(body)) + plain[head:]
