"""Both detectors on all levels: prints the table of docs/detection.md, asserts nothing about speed."""

from __future__ import annotations

import sys

import pytest

from rehab_app.cameras.levels import LEVELS
from rehab_app.vision import DETECTORS, make_detector
from tests.bench.tracking.detection import detection_score

pytestmark = pytest.mark.bench

SEEDS = (501, 502, 503, 504, 505)


def test_detectors_at_every_level() -> None:
    lines = ["detector, view, level: recall / precision / centre rms px / point median mm / ms"]
    for name in DETECTORS:
        for window in (False, True):
            for level in LEVELS:
                score = detection_score(make_detector(name), level, SEEDS, window=window)
                lines.append(
                    f"{name}, {'window' if window else 'whole'}, {level}: {score.recall:.3f} / "
                    f"{score.precision:.3f} / {score.centre_rms_px:.2f} / "
                    f"{1e3 * score.point_median_m:.2f} / {score.ms:.1f}"
                )
                if name == "contrast" and level == "hard":
                    assert score.recall > 0.97
                    assert score.precision > 0.97
                    assert score.centre_rms_px < 0.45
    sys.stdout.write("\n" + "\n".join(lines) + "\n")
