"""Figures 5.11 and 5.12 of the thesis: the arm brings the hand, the hand closes; in simulation."""

from __future__ import annotations

import math
from functools import cache

from rehab_app.grasp.reach import Reached, reach_for
from rehab_app.grasp.reproduction import Line, Part
from robot_iface.build import draw_reach

RADII_M = (0.020, 0.0225)
"""The two cylinders of section 5.2.3."""
PICTURE = "figures/figure-5.12.svg"
"""Our Figure 5.12, beside the document."""


@cache
def _reached(radius_m: float) -> Reached:
    return reach_for(radius_m)


def reach_part() -> Part:
    """Both figures, with what became of the two cylinders."""
    return Part(
        "Figures 5.11 and 5.12: reach and grasp",
        "The thesis shows photographs of the real arm and hand and paths without numbers. Ours is a "
        "simulation with contact (`docs/reach-and-grasp.md`), with the thesis's gains, times and places of "
        "the arm; the object's weight, friction and height are assumptions, chosen with the result in sight. "
        "A long cylinder is knocked over by the thumb's fixed base, so ours ends below it, and palm, middle, "
        f"ring and little finger hold it alone. Picture: [`{PICTURE}`]({PICTURE}), r = 20 mm.",
        tuple(_line(radius_m) for radius_m in RADII_M),
    )


def reach_picture() -> str:
    """Figure 5.12 as SVG: all joints' paths around the cylinder of 20 mm, their angles over time."""
    return draw_reach(_reached(RADII_M[0]).grasp)


def _line(radius_m: float) -> Line:
    reached = _reached(radius_m)
    gravity_mm, pushed_mm = (1e3 * float(moved) for moved in reached.moved_m)
    farthest_mm, last_mm = (1e3 * float(off) for off in reached.arm_error_m)
    holds = "holds" if reached.grasp.holds else "does not hold"
    ours = (
        f"{holds}: moved {gravity_mm:.1f} mm by gravity, {pushed_mm:.1f} mm under the worst of six pushes of "
        f"0.5 N, turned {math.degrees(reached.turned_rad):.1f} deg; arm within {farthest_mm:.1f} mm of "
        f"its way, {last_mm:.1f} mm at the end"
    )
    return Line(f"cylinder of r = {1e3 * radius_m:g} mm", "grasped (photograph)", ours, "-")
