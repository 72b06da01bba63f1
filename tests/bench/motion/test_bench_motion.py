"""``make bench-motion``: one table of the motion core's figures, each with its must, its aim and its peer."""

from __future__ import annotations

import sys
from collections.abc import Callable

import pytest

from tests.bench.motion.figures import fit_rows, kinematics_rows, trigger_rows
from tests.bench.motion.guard import guard_rows
from tests.bench.motion.paths import path_rows
from tests.bench.motion.table import Row, at_most, lines
from tests.bench.motion.therapy import therapy_rows
from tests.bench.motion.tick import tick_row
from tests.robot_iface.conftest import fist, make_plan

pytestmark = pytest.mark.bench
KNOWN_SHORT = (
    *("worst peak torque / unsupervised", "worst peak speed / unsupervised"),
    *(
        "healthy, path of 3 s from 8 deg, started by the patient",
        "weak, path of 3 s from 8 deg, started by the patient",
    ),
)
"""What docs/benchmarks.md says falls short; all else must hold."""


def tick_rows() -> list[Row]:
    """A tick without physics beside the same duties in numpy, every mode."""
    rows: list[Row] = []
    for mode in ("passive", "assistive", "transparent", "resistive"):
        row = tick_row(make_plan("healthy", mode, path=fist(4.0)))
        what = f"{mode} tick without physics ({row.ours_us:.1f} us) / numpy ({row.numpy_us:.1f} us)"
        rows.append(at_most(what, row.ratio, 0.5, 0.2))
    return rows


PARTS: dict[str, Callable[[], list[Row]]] = {
    "kinematics": kinematics_rows,
    "fit": fit_rows,
    "path": path_rows,
    "therapy": therapy_rows,
    "trigger": trigger_rows,
    "guard": guard_rows,
    "tick": tick_rows,
}


@pytest.mark.parametrize("part", PARTS)
def test_every_figure_that_must_hold_holds(part: str) -> None:
    rows = PARTS[part]()
    sys.stderr.write("\n" + "\n".join(lines(rows)[0 if part == "kinematics" else 2 :]) + "\n")
    short = [row.what for row in rows if not row.holds and not row.what.endswith(KNOWN_SHORT)]
    assert short == []
