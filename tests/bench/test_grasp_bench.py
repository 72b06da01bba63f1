"""Target grips: speed beside scipy's Nelder-Mead in the same run; the whole grid of hands and cylinders."""

from __future__ import annotations

import math
import sys
import time
from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from rehab_app.errors import Refused
from rehab_app.grasp.hand import human_hand, robot_hand
from rehab_app.grasp.newton import TangentObjective
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import try_posture
from robot_iface.kinematics import average_hand

pytestmark = pytest.mark.bench

BATCH = 1000
LENGTHS_M = np.arange(0.160, 0.2101, 0.005)
RADII_M = np.arange(0.010, 0.06001, 0.0005)


def tell(text: str) -> None:
    sys.stdout.write(text + "\n")


def quickest_s(work: Callable[[], object], rounds: int) -> float:
    """Least time of several rounds, s: what the machine's other work adds is not the method's."""
    times_s = []
    for _ in range(rounds):
        start_s = time.perf_counter()
        work()
        times_s.append(time.perf_counter() - start_s)
    return min(times_s)


def test_newton_beside_nelder_mead() -> None:
    objective = TangentObjective(robot_hand())
    radii_m = np.random.default_rng(81).uniform(0.02, 0.06, BATCH)

    def peer() -> object:
        # the thesis's fminsearch, on the quickest objective we have, to the same 1e-10 m
        options = {"xatol": 1e-11, "fatol": 1e-15, "maxiter": 4000}
        return minimize(
            lambda x: objective.value(x[0], math.tan(x[1]), 0.0225),
            [0, 0],
            method="Nelder-Mead",
            options=options,
        )

    peer_s = quickest_s(peer, 30)
    one_s = quickest_s(lambda: objective.minimum(0.0225), 300)
    many_s = quickest_s(lambda: objective.minima(radii_m), 100) / BATCH
    tell(
        f"\nNelder-Mead {1e3 * peer_s:.2f} ms; Newton {1e6 * one_s:.1f} us ({peer_s / one_s:.0f}x); "
        f"in batches of {BATCH} {1e6 * many_s:.2f} us a posture ({peer_s / many_s:.0f}x)"
    )
    assert peer_s / one_s >= 60
    assert peer_s / many_s >= 3000


@pytest.mark.parametrize("grip", ["transverse", "diagonal"])
@pytest.mark.parametrize("length_m", LENGTHS_M, ids=lambda value: f"{1e3 * value:.0f}mm")
def test_no_digit_cuts_over_the_whole_grid(length_m: float, grip: str) -> None:
    hand = human_hand(average_hand(float(length_m)))
    deepest_m, thumbs, left_out, reasons = 0.0, 0, 0, Counter[str]()
    for radius_m in RADII_M:
        try:
            posture = try_posture(hand, Cylinder(float(radius_m)), grip, "contact", None)
        except Refused as refusal:
            reasons[refusal.value.partition(":")[0]] += 1
            continue
        deepest_m = max(deepest_m, posture.penetration_m)
        left_out += any("left out" in said for said in posture.warnings)
        thumbs += any(at.digit == "thumb" for at in posture.contacts)
    tell(
        f"\n{grip}, hand {1e3 * length_m:.0f} mm: deepest {1e3 * deepest_m:.4f} mm, thumb touches "
        f"{thumbs / len(RADII_M):.0%}, is left out {left_out / len(RADII_M):.0%}, refused "
        f"{sum(reasons.values()) / len(RADII_M):.0%} {dict(reasons)}"
    )
    assert deepest_m <= 1e-5
