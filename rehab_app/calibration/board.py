"""The board that is held before a camera: a chessboard, or one with numbered markers in its white squares."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import cv2
import numpy as np

from sessions.errors import Refused
from sessions.records.fields import Float64

Kind: TypeAlias = Literal["chessboard", "charuco"]
DICTIONARIES = ("4x4_50", "4x4_100", "4x4_250", "5x5_100", "5x5_250", "6x6_250", "apriltag_36h11")
_SQUARE_M = (0.002, 0.5)
_COUNT = (3, 40)
_SPEC = re.compile(r"(?:(chessboard|charuco):)?(\d{1,3})x(\d{1,3})", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Board:
    """A flat board of squares.

    Its frame begins at the first inner corner: x along the columns, y along the rows, z into the board.

    Attributes:
        kind: "chessboard" or "charuco".
        columns: Inner corners along x.
        rows: Inner corners along y.
        square_m: Side of a square.
        marker_m: Side of a marker (charuco only).
        dictionary: Which markers, one of DICTIONARIES (charuco only).

    Raises:
        Refused: A size or count is not that of a board.
    """

    kind: Kind
    columns: int
    rows: int
    square_m: float
    marker_m: float = 0.0
    dictionary: str = "4x4_50"

    def __post_init__(self) -> None:
        fewest = _COUNT[0] if self.kind == "chessboard" else 2
        if not fewest <= min(self.columns, self.rows) <= max(self.columns, self.rows) <= _COUNT[1]:
            raise Refused(
                "board",
                f"{self.columns} x {self.rows} inner corners",
                f"{fewest} to {_COUNT[1]} each way",
                "count the places where four squares meet",
            )
        if not _SQUARE_M[0] <= self.square_m <= _SQUARE_M[1]:
            raise Refused(
                "square of the board",
                f"{self.square_m:g} m",
                f"{_SQUARE_M[0]:g} to {_SQUARE_M[1]:g} m",
                "measure one square and give it in metres (25 mm is 0.025)",
            )
        if self.kind == "charuco" and not 0.3 <= self.marker_m / self.square_m <= 0.95:
            raise Refused(
                "marker of the board",
                f"{self.marker_m:g} m",
                f"{0.3 * self.square_m:.3g} to {0.95 * self.square_m:.3g} m in such squares",
                "measure the black border of one marker",
            )
        if self.dictionary not in DICTIONARIES:
            raise Refused(
                "marker dictionary",
                repr(self.dictionary),
                "one of " + ", ".join(DICTIONARIES),
                "choose the one that the board was printed with",
            )

    @property
    def points_m(self) -> Float64:
        """The inner corners in the board's frame, row by row, shape (rows * columns, 3)."""
        y, x = np.mgrid[0 : self.rows, 0 : self.columns]
        return np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3) * self.square_m

    @property
    def one_way_up(self) -> bool:
        """Whether the board looks different after half a turn, so that its first corner can be told."""
        return self.kind == "charuco" or (self.columns + self.rows) % 2 == 1

    @property
    def description(self) -> str:
        """The board in words, for people and for the file of the calibration."""
        size = f"{1e3 * self.square_m:g} mm"
        if self.kind == "chessboard":
            return f"chessboard, {self.columns} x {self.rows} inner corners, squares of {size}"
        squares = f"{self.columns + 1} x {self.rows + 1} squares of {size}"
        return f"charuco board, {squares}, markers {self.dictionary} of {1e3 * self.marker_m:g} mm"


def parse_board(
    spec: str, square_m: float, marker_m: float | None = None, dictionary: str = "4x4_50"
) -> Board:
    """A board from what a person types.

    Args:
        spec: "9x6" or "chessboard:9x6" counts inner corners; "charuco:7x5" counts squares, as its makers do.
        square_m: Side of a square.
        marker_m: Side of a marker; by default three quarters of the square.
        dictionary: One of DICTIONARIES.

    Raises:
        Refused: The text is none of these, or the numbers are those of no board.
    """
    match = _SPEC.fullmatch(spec.strip())
    if match is None:
        raise Refused(
            "--board", repr(spec[:40]), "like 9x6 (inner corners) or charuco:7x5 (squares)", "count them"
        )
    kind, columns, rows = (match[1] or "chessboard").lower(), int(match[2]), int(match[3])
    if kind == "charuco":
        marker = 0.75 * square_m if marker_m is None else marker_m
        return Board("charuco", columns - 1, rows - 1, square_m, marker, dictionary.lower())
    return Board("chessboard", columns, rows, square_m)


def marker_dictionary(board: Board) -> Any:
    """The library's dictionary of a marked board."""
    name = board.dictionary
    return cv2.aruco.getPredefinedDictionary(
        getattr(cv2.aruco, "DICT_" + (name.upper() if name[0].isdigit() else "APRILTAG_36h11"))
    )


def charuco_board(board: Board, *, white_first: bool = False) -> Any:
    """The library's own description of a marked board.

    Args:
        board: A charuco board.
        white_first: Whether a corner square is white, as OpenCV printed even numbers of rows before 4.6.
    """
    squares = (board.columns + 1, board.rows + 1)
    described = cv2.aruco.CharucoBoard(squares, board.square_m, board.marker_m, marker_dictionary(board))
    described.setLegacyPattern(white_first)
    return described
