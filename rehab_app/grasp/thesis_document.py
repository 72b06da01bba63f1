"""Puts the reproduction of the thesis together."""

from __future__ import annotations

from rehab_app.grasp.reproduction import document
from rehab_app.grasp.reproduction_grips import chapter_5
from rehab_app.grasp.reproduction_measures import chapter_3
from rehab_app.grasp.reproduction_reach import PICTURE, reach_picture
from rehab_app.grasp.reproduction_tracking import chapter_4


def thesis_document() -> str:
    """Chapters 3 to 5 of the thesis beside ours, in Markdown; the same text wherever it is made."""
    return document(
        (
            ("Chapter 3: hands measured", chapter_3()),
            ("Chapter 4: hands tracked", chapter_4()),
            ("Chapter 5: grips predicted", chapter_5()),
        )
    )


def thesis_pictures() -> dict[str, str]:
    """The pictures that the document names, as SVG by their path from the document."""
    return {PICTURE: reach_picture()}
