"""Prints the joint fit beside its peer and asserts the bound that must hold."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from tests.bench.motion.fit import NOISES_M, fit_table

pytestmark = pytest.mark.bench
MUST = 0.7


def test_the_joint_fit_beats_filter_then_inverse() -> None:
    rows = fit_table()
    for row in rows:
        sys.stderr.write(
            f"\n{row.seen:10s} {1e3 * row.noise_m:.0f} mm  {row.movement:14s} "
            f"{np.rad2deg(row.fit_rad):5.2f} deg, "
            f"filtered at {row.cutoff_hz:.0f} Hz {np.rad2deg(row.peer_rad):5.2f} deg, ratio {row.ratio:.2f}, "
            f"{row.fit_ms:.0f} ms"
        )
    for seen in ("fingertips", "landmarks"):
        for noise_m in NOISES_M:
            mine = [row for row in rows if row.seen == seen and row.noise_m == noise_m]
            fit, peer = (
                np.sqrt(np.mean([getattr(row, one) ** 2 for row in mine])) for one in ("fit_rad", "peer_rad")
            )
            sys.stderr.write(f"\n{seen} at {1e3 * noise_m:.0f} mm, all movements: ratio {fit / peer:.2f}")
            assert fit <= MUST * peer
