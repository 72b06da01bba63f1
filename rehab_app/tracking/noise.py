"""How far blobs lie from where the fitted hand has its markers: learnt while tracking.

Two things are told apart by how they change from capture to capture. What the image adds is new every time;
what the model lacks (skin that slides, paper that bends) stays much the same.
"""

from __future__ import annotations

import numpy as np

from rehab_app.tracking.hand_filter import Pairs, Placed, rows_of
from rehab_app.tracking.hand_state import HandState
from rehab_app.tracking.sight import Sight
from sessions.records.fields import Float64

_LEAST_SHARE = 0.25  # of what the protocol states
_MOST_WOBBLE_M = 0.006
_SCALE = (0.5, 6.0)
_MEMORY = 600.0  # pairs that the figures remember
_WILD = 4.0  # standard deviations that a residual counts as at most


class Noise:
    """Running figures of one tracked hand.

    Args:
        markers: How many markers there are.
        wobble_m: Standard deviation of a marker's place on its bone to begin with.
    """

    def __init__(self, markers: int, wobble_m: float) -> None:
        self._last: Float64 = np.full((markers, 2), np.nan)
        self._wobble_m2 = wobble_m**2
        self._least_m2 = (_LEAST_SHARE * wobble_m) ** 2
        self._scale2 = 1.0

    @property
    def wobble_m2(self) -> float:
        """Variance of a marker's place on its bone, per axis, m^2."""
        return float(np.clip(self._wobble_m2, self._least_m2, _MOST_WOBBLE_M**2))

    @property
    def across_scale(self) -> float:
        """Factor on the stated standard deviation across the rays."""
        return float(np.sqrt(np.clip(self._scale2, _SCALE[0] ** 2, _SCALE[1] ** 2)))

    def feed(self, state: HandState, after: Placed, sight: Sight, pairs: Pairs) -> None:
        """Take what is left between the hand after a capture and the blobs in it."""
        rows = rows_of(after, sight, pairs, self.wobble_m2)
        residual = rows.residual_m[:, :2]
        variance = rows.variance_m2[:, :2]
        slopes = rows.slopes[:, :2]
        used = np.einsum("kai,ij,kaj->ka", slopes, state.position_covariance, slopes)
        # of each residual the fit took its share
        kept = np.clip(1.0 - used / variance, 0.1, 1.0)
        residual = np.clip(residual, -_WILD * np.sqrt(variance), _WILD * np.sqrt(variance))
        usual = pairs.extra_m2 == 0.0
        last = self._last[pairs.marker]
        self._last = np.full_like(self._last, np.nan)
        self._last[pairs.marker] = residual
        if not usual.any():
            return
        share = float(usual.sum()) / _MEMORY
        whole = float(((residual**2 / kept)[usual]).mean())
        stated = float(
            (
                sight.across_rad2[pairs.row][usual]
                / self.across_scale**2
                * self._ranges2(sight, after, pairs)[usual]
            ).mean()
        )
        both = usual & np.isfinite(last[:, 0])
        if both.any():
            change = float((((residual - last) ** 2 / kept)[both]).mean()) / 2.0
            self._scale2 += min(share, 0.2) * (change / stated - self._scale2)
        self._wobble_m2 += min(share, 0.2) * (
            max(whole - self.across_scale**2 * stated, 0.0) - self._wobble_m2
        )

    @staticmethod
    def _ranges2(sight: Sight, after: Placed, pairs: Pairs) -> Float64:
        apart = after.p_m[pairs.marker] - sight.detections.origin_camera_m[pairs.row]
        return (apart**2).sum(axis=1)
