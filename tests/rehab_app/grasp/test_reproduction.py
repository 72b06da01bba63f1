"""The document is what the code gives, and its figures are those that the issue of the grips asks for."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rehab_app.grasp.reproduction import compared
from rehab_app.grasp.thesis_document import thesis_document, thesis_pictures

FILE = Path(__file__).resolve().parents[3] / "docs" / "thesis-reproduction.md"


@pytest.fixture(scope="module")
def made() -> str:
    return thesis_document()


def test_the_file_is_what_the_command_makes(made: str) -> None:
    assert FILE.read_text(encoding="utf-8") == made


def test_the_pictures_lie_beside_it(made: str) -> None:
    for name, svg in thesis_pictures().items():
        assert f"]({name})" in made
        kept = (FILE.parent / name).read_text(encoding="utf-8")
        # drawn to a tenth of a pixel, which another processor's arithmetic may turn over
        assert [line.count(" ") for line in kept.splitlines()] == [
            line.count(" ") for line in svg.splitlines()
        ]


def test_every_table_and_figure_of_chapters_3_to_5_is_there(made: str) -> None:
    headings = " ".join(line for line in made.splitlines() if line.startswith("### "))
    for chapter, tables, figures in ((3, 6, 15), (4, 1, 6), (5, 4, 12)):
        for kind, last in (("Table", tables), ("Figure", figures)):
            for number in range(1, last + 1):
                assert named(headings, kind, chapter, number), f"{kind} {chapter}.{number}"


def named(headings: str, kind: str, chapter: int, number: int) -> bool:
    """Whether a heading names it, alone or in a span such as "Figures 3.6 to 3.14"."""
    for first, last in re.findall(
        rf"{kind}s? {chapter}\.(\d+)(?:(?: to| and|, .*? and) {chapter}\.(\d+))?", headings
    ):
        if int(first) <= number <= int(last or first):
            return True
    return False


@pytest.mark.parametrize(
    "figure",
    [
        "48.60 +- 1.91 deg",
        "52.48 +- 3.34 deg",
        "56.08 deg",
        "28.91 +- 2.45 mm",
        "z -7.262 mm, alpha -10.251 deg, f 0.264669 m; the same from 300 of 300 starts",
        "mean 7.7 %, worst 11.4 %",
        "mean 14.5 %, worst 21.7 %",
        "below 1e-12",
        "kinematic 25 of 25",
        "holds: moved 1.0 mm by gravity, 2.1 mm under the worst of six pushes",
        "holds: moved 1.5 mm by gravity, 2.8 mm under the worst of six pushes",
    ],
)
def test_the_oracles_are_in_it(made: str, figure: str) -> None:
    assert figure in made


def test_a_difference_is_absolute_and_relative() -> None:
    line = compared("x", 20.0, 22.5, "mm", 1)
    assert (line.thesis, line.ours, line.difference) == ("20.0 mm", "22.5 mm", "+2.5 mm (+12.5 %)")
